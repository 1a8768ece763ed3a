"""A benchmark that is killed goes on where it stopped."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import msgspec
import pytest
from filelock import FileLock

from studio.bench.cli import main
from studio.bench.matrix import parse_matrix
from studio.bench.order import Order
from studio.bench.store import SCHEMA, Store
from studio.bench.worker import LOST, measure
from tests.studio.bench.tiny import TINY, job

ROOT = Path(__file__).parents[3]
JOBS = parse_matrix(TINY, "tiny").jobs
ENVIRONMENT = os.environ | {"PYTHONPATH": str(ROOT)}
PATIENCE = 240.0
"""Seconds for a run on a machine that does much else."""


def command(folder, *more):
    arguments = ["run", str(folder / "tiny.toml"), "--out", str(folder / "store"), *more]
    return [sys.executable, "-m", "studio.bench.cli", *arguments]


def wait_for(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


@pytest.fixture(scope="module")
def killed(tmp_path_factory, disk_cache):
    """Folder of a benchmark that was killed when its first run of two was finished."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "tiny.toml").write_text(TINY)
    store = Store(folder / "store")
    runner = subprocess.Popen(command(folder), env=ENVIRONMENT, stdout=subprocess.DEVNULL)
    wait_for(lambda: store.finished(JOBS[0].key) and store.log(JOBS[1].key).exists())
    runner.kill()
    runner.wait()
    return folder


@pytest.fixture(scope="module")
def resumed(killed):
    """What was there when it was killed, and the output of the same command again."""
    store = Store(killed / "store")
    before = {path.name: path.stat().st_mtime_ns for path in store.folder.glob("runs/*.parquet")}
    again = subprocess.run(
        command(killed), env=ENVIRONMENT, capture_output=True, text=True, check=False
    )
    return store, before, again


def test_no_finished_run_is_repeated_and_none_is_lost(resumed):
    store, before, again = resumed
    assert again.returncode == 0, again.stderr
    *lines, last = map(json.loads, again.stdout.splitlines())
    assert (last["runs"], last["already_finished"], last["failed"]) == (2, 1, 0)
    assert [line["run"] for line in lines] == [JOBS[1].key]
    assert list(before) == [f"{JOBS[0].key}.parquet"]
    for name, written in before.items():
        assert (store.folder / "runs" / name).stat().st_mtime_ns == written
    assert sorted(row["key"] for row in store.rows()) == sorted(one.key for one in JOBS)


def test_a_row_says_all_about_its_run(resumed):
    store, _, _ = resumed
    for row in store.rows():
        assert row["status"] == "finished" and list(row) == SCHEMA.names
        assert (row["robot"], row["task"], row["variant"]) == ("linear", "linear-demo", "tiny")
        assert row["epochs"] == 2 and [point["epoch"] for point in row["curve"]] == [1, 2]
        assert 0 <= row["success_rate"] <= 1 and row["wall_seconds"] > row["train_seconds"] > 0
        assert row["peak_bytes"] > 10**8
        assert row["stopped"] == "epochs" and row["concurrent"] == 1 and row["cores"] >= 1
        assert row["cpu_seconds"] > row["train_cpu_seconds"] > 0
        assert row["curve"][-1]["cpu_seconds"] <= row["train_cpu_seconds"]
        assert row["versions"]["jax"] and row["machine"]["cores"]
        assert json.loads(row["job"])["changes"]["hidden"] == [16]
        assert json.loads(row["configuration"])["algorithm"]["environments"] == 16


def test_a_process_ends_with_its_runner(tmp_path):
    worker = subprocess.Popen(
        [sys.executable, "-m", "studio.bench.worker", str(tmp_path)],
        stdin=subprocess.PIPE,
        env=ENVIRONMENT,
    )
    assert worker.stdin is not None
    worker.stdin.write(msgspec.json.encode(Order(job(epochs=10**6))) + b"\n")
    worker.stdin.close()
    assert worker.wait(PATIENCE) == LOST
    assert not list(tmp_path.iterdir())


def test_one_at_a_time(tmp_path, capsys):
    (tmp_path / "tiny.toml").write_text(TINY)
    (tmp_path / "store").mkdir()
    with FileLock(tmp_path / "store" / "lock"):
        assert main(command(tmp_path)[3:]) == 2
    assert "another tgpo-bench adds runs to it" in capsys.readouterr().err


def test_a_run_that_breaks_down_is_told_and_not_kept(tmp_path, capsys, monkeypatch):
    (tmp_path / "tiny.toml").write_text(TINY)
    monkeypatch.setattr(sys, "executable", "/bin/false")
    assert main(command(tmp_path)[3:]) == 1
    *lines, last = map(json.loads, capsys.readouterr().out.splitlines())
    assert [line["failure"] for line in lines] == ["exit status 1: nothing was said"] * 2
    assert last["failed"] == 2
    assert Store(tmp_path / "store").rows() == []


def test_a_budget_of_processor_seconds_ends_a_run(tmp_path):
    (tiny, _) = parse_matrix(
        TINY.replace("epochs = 2", "epochs = 100000\ncpu_seconds = 0.5"), "t"
    ).jobs
    row = measure(tiny, concurrent=2)
    assert (row["stopped"], row["concurrent"]) == ("cpu_seconds", 2)
    assert row["train_cpu_seconds"] >= 0.5 and 1 <= row["epochs"] < 100000


def test_what_is_not_allowed_is_kept_as_refused():
    row = measure(job(task="linear-05", horizon=10))
    assert row["status"] == "refused" and "cannot" in row["message"] or "least" in row["message"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "smok", "--out", "x"), "matrix: unknown 'smok'"),
        (("run", "smoke", "--out", "x", "--processes", "0"), "--processes: 0 must be"),
        (("report", "nowhere"), "not a benchmark's folder"),
    ],
)
def test_wrong_arguments(capsys, tmp_path, monkeypatch, arguments, message):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
