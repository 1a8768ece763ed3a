"""`docs/own-robot.md`, carried out word by word in a copy of the program."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "own-robot.md"
PACKAGES = ("core", "envs", "scenes", "static", "studio")

PROBE = """
import io, json, sys
from contextlib import redirect_stdout
import numpy as np
from envs import ENVS
from scenes import demo_names, load_task, robot_of, world_of
from studio.page.server.security import start_server
from studio.page.views.bodies import body_of
from studio.page.views.bodies.ball import Ball
from studio.page.views.bodies.body import ROOT
from tests.studio.conftest import free_port

scene = load_task("slider-demo")
robot = robot_of(scene)
body = body_of(robot)
with redirect_stdout(io.StringIO()):
    server = start_server("127.0.0.1", free_port(), "slider")
    parts = body.build(server.scene, "/robot")
    server.stop()
print(json.dumps({
    "demos": demo_names("slider"),
    "known": ENVS["slider"] == robot,
    "shape": world_of(scene).grid.shape,
    "ball": isinstance(body, Ball),
    "parts": sorted(parts),
    "floor": body.stage.floor,
    "root": body.poses(np.array([1.0, -2.0, 0.3, 0.4], np.float32))[ROOT].position.tolist(),
}))
"""


def _section(number: int) -> str:
    found = re.search(rf"^## {number}\. .*?(?=^## |\Z)", PAGE.read_text(), re.M | re.S)
    assert found
    return found.group()


def _blocks(number: int, language: str) -> list[str]:
    blocks = re.findall(r"^```(\w*)\n(.*?)^```$", _section(number), re.M | re.S)
    return [text for kind, text in blocks if kind == language]


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """The program with the page's robot in it: one file, one line (and its import), one scene."""
    folder = tmp_path_factory.mktemp("own-robot")
    for name in (*PACKAGES, "tests"):
        ignored = shutil.ignore_patterns("__pycache__", "witnesses")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)
    (robot,) = _blocks(1, "python")
    (folder / "envs" / "slider.py").write_text(robot)
    (line_of_import,), (line,) = _blocks(2, "python"), _blocks(2, "text")
    listing = (folder / "envs" / "__init__.py").read_text()
    listing = listing.replace("from envs.unicycle", f"{line_of_import}from envs.unicycle")
    listing = listing.replace("    Ant(),\n", f"    Ant(),\n{line}")
    (folder / "envs" / "__init__.py").write_text(listing)
    (scene,) = _blocks(3, "toml")
    (folder / "scenes" / "slider").mkdir()
    (folder / "scenes" / "slider" / "demo.toml").write_text(scene)
    return folder


def _run(folder: Path, *command: str) -> str:
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_check_finds_it_sound(copy):
    (command,) = [block for block in _blocks(2, "") if "envs.check" in block]
    python, *arguments = command.split()
    assert python == "python"
    assert _run(copy, sys.executable, *arguments) == "slider: sound\n"


def test_it_has_a_world_and_a_body(copy):
    found = json.loads(_run(copy, sys.executable, "-c", PROBE).splitlines()[-1])
    assert found == {
        "demos": ["slider-demo"],
        "known": True,
        "shape": [81, 81],
        "ball": True,
        "parts": [],
        "floor": [[-5.0, 5.0], [-5.0, 5.0]],
        "root": [1.0, -2.0, 0.0],
    }


def test_it_trains_and_is_evaluated(copy):
    """By the commands of the page, with a budget of one epoch and small networks."""
    (commands,) = _blocks(4, "")
    lines = [re.sub(r"\s+#.*", "", line) for line in commands.splitlines()]
    train, evaluate, page = (line.split()[1:] for line in lines[1:])
    assert page == ["--task", "slider-demo"]
    code = (
        "import sys; from core.methods.tgpo import method; from tests.small import shrink\n"
        "make = method.make_algorithm\n"
        "method.make_algorithm = lambda *given: shrink(make(*given))\n"
        "from studio.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    trained = _run(copy, sys.executable, "-c", code, *train, "--epochs", "1", "--target", "2")
    assert json.loads(trained.splitlines()[-1])["task"] == "slider-demo"
    evaluated = json.loads(_run(copy, sys.executable, "-c", code, *evaluate).splitlines()[-1])
    assert evaluated["initial_states"] == 512


def test_weights_are_trained_for_it_and_plan(copy):
    """By the commands of the page, with a budget of one epoch, small networks, few missions."""
    (commands,) = _blocks(5, "")
    pretrain, plan = (line.split()[1:] for line in commands.splitlines())
    small = (
        "from dataclasses import replace\n"
        "from studio.runs import held_out, missions, outcomes, pretraining\n"
        "many = pretraining.many_missions\n"
        "pretraining.many_missions = lambda *given: replace(\n"
        "    shrink(many(*given)), layouts=2, fresh_layouts=1)\n"
        "missions.VALIDATIONS, held_out.HELD_OUT, outcomes.MISSIONS = 1, (), 8\n"
    )
    code = (
        f"import sys; from tests.small import shrink\n{small}"
        "from studio.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    trained = _run(copy, sys.executable, "-c", code, *pretrain, "--epochs", "1")
    card = json.loads(trained.splitlines()[-1])
    assert card["robot"] == "slider" and card["out"] == plan[-1]
    planned = _run(copy, sys.executable, "-c", code, *plan)
    assert json.loads(planned)["task"] == "slider-demo"


def test_every_body_that_the_page_names_exists():
    from studio.page.views.bodies import BODIES

    (named,) = re.findall(r"^\* `drawn_as`: (.*?)\.", PAGE.read_text(), re.M)
    assert set(re.findall(r"`(\w+)`", named)) == set(BODIES)
