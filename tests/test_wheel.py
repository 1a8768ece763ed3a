"""A wheel, installed elsewhere, runs: data files are in it and nothing reaches back here."""

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Folder with the unpacked wheel."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir"]
    source = folder / "source"
    subprocess.run(["git", "clone", "-q", str(ROOT), str(source)], check=True)
    subprocess.run([*command, str(folder), str(source)], check=True, capture_output=True)
    (wheel,) = folder.glob("tgpo_studio-*.whl")
    target = folder / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(target)
    return target


def _run(installed, tmp_path, *arguments):
    environment = os.environ | {"PYTHONPATH": str(installed)}
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


def test_the_wheel_s_own_modules_load_its_tasks(installed, tmp_path):
    code = (
        "import core, scenes\n"
        "from studio.runs.tasks import build_task\n"
        "task = build_task(scenes.load_task('unicycle-10'))\n"
        "print(core.__file__, task.horizon, len(scenes.task_names()))"
    )
    result = _run(installed, tmp_path, "-c", code)
    assert result.returncode == 0, result.stderr
    where, horizon, count = result.stdout.split()
    assert Path(where).is_relative_to(installed)
    assert (horizon, int(count) >= 20) == ("100", True)


def test_the_wheel_s_command_runs(installed, tmp_path):
    result = _run(installed, tmp_path, "-m", "studio", "--list")
    assert result.returncode == 0, result.stderr
    assert "linear-08" in result.stdout


def test_gymnasium_finds_the_wheel_s_tasks_without_an_import_of_ours(installed, tmp_path):
    code = (
        "import sys, gymnasium\n"
        "assert 'jax' not in sys.modules\n"
        "env = gymnasium.make('tgpo/linear-08-v0')\n"
        "print(sys.modules['studio'].__path__[0], env.reset(seed=1)[0].size)"
    )
    result = _run(installed, tmp_path, "-c", code)
    assert result.returncode == 0, result.stderr
    where, size = result.stdout.split()
    assert Path(where).is_relative_to(installed)
    assert int(size) == 2 + 1 + 8


def test_the_wheel_carries_data_and_licence_but_no_tests(installed):
    assert (installed / "scenes" / "linear" / "01.toml").exists()
    assert (installed / "studio" / "bench" / "matrices" / "smoke.toml").exists()
    assert (installed / "studio" / "bench" / "published.toml").exists()
    assert list(installed.glob("tgpo_studio-*.dist-info/licenses/LICENSE"))
    assert not (installed / "tests").exists()
