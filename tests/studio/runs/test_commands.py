"""Training, resuming and evaluating from the command line, with a small algorithm."""

import errno
import io
import json
import os
import signal
import subprocess
import sys
import threading
from dataclasses import replace
from pathlib import Path

import jax.numpy as jnp
import pytest
from rich.console import Console

from core.methods.tgpo import method
from core.methods.tgpo.algorithm import Algorithm
from core.methods.training import TrainingConfig, train
from studio.cli import main
from studio.runs import commands
from studio.runs.reporting import BarReporter, LineReporter, make_reporter, seconds_left
from studio.runs.stopping import StopRequest
from tests.small import shrink

ROOT = Path(__file__).parents[3]
LAST_LINE = [
    *("task", "method", "mode", "seed", "success_rate", "robustness_mean", "between_rate"),
    *("epochs", "env_steps", "train_seconds", "compile_seconds", "out"),
]


@pytest.fixture
def here(tmp_path, monkeypatch, disk_cache):
    """An empty working directory, and algorithms that are small."""
    original = method.make_algorithm
    monkeypatch.setattr(method, "make_algorithm", lambda *given: shrink(original(*given)))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(capsys, *arguments: str) -> tuple[int, list[dict], str]:
    """Exit status, JSON lines of standard output, standard error."""
    status = main(arguments)
    captured = capsys.readouterr()
    return status, [json.loads(line) for line in captured.out.splitlines()], captured.err


def test_train_resume_evaluate(here, capsys):
    train_it = ("--train-only", "--task", "linear-08", "--target", "2", "--out", "runs/x")
    status, lines, _ = run(capsys, *train_it, "--epochs", "3", "--seed", "4")
    assert status == 0
    assert [line.get("epoch") for line in lines] == [1, 2, 3, None]
    last = lines[-1]
    assert list(last) == LAST_LINE
    assert (last["task"], last["method"], last["mode"]) == ("linear-08", "tgpo-star", "studio")
    assert (last["seed"], last["epochs"], last["out"]) == (4, 3, "runs/x")

    status, lines, errors = run(capsys, *train_it)
    assert status == 2 and "runs/x: exists and is not empty" in errors and not lines

    status, lines, _ = run(capsys, "--resume", "runs/x", "--epochs", "5")
    assert status == 0
    assert [line.get("epoch") for line in lines] == [4, 5, None]

    status, (own,), _ = run(capsys, "--evaluate", "runs/x")
    assert status == 0 and own["success_rate"] == lines[-1]["success_rate"]
    assert own["robustness_mean"] == lines[-1]["robustness_mean"]
    assert own["initial_states"] == 512

    elsewhere = ("--evaluate", "runs/x/bundle", "--task", "linear-07", "--formula", "F_[0:9](A1)")
    status, (other,), _ = run(capsys, *elsewhere)
    assert (other["task"], other["trained_on"]) == ("linear-07", "linear-08")
    assert other["formula"] == "F_[0:9](A1)"
    assert other["robustness_mean"] != own["robustness_mean"]

    status, _, errors = run(capsys, "--evaluate", "runs/x", "--task", "unicycle-03")
    assert status == 2 and "policy for the robot 'linear' cannot carry out unicycle-03" in errors


@pytest.mark.optimised
def test_many_layouts_train_resume_evaluate(here, capsys):
    train_it = ("--train-only", "--task", "linear-07", "--randomize", "--target", "2")
    status, lines, _ = run(capsys, *train_it, "--epochs", "2", "--out", "runs/whole")
    assert status == 0 and lines[-1]["epochs"] == 2
    kept = json.loads((here / "runs/whole/config.json").read_text())
    assert kept["algorithm"]["layouts"] == 16 and kept["algorithm"]["fresh_layouts"] == 1

    run(capsys, *train_it, "--epochs", "1", "--out", "runs/part")
    status, resumed, _ = run(capsys, "--resume", "runs/part", "--epochs", "2")
    assert status == 0 and resumed[0]["batch_return"] == lines[1]["batch_return"]

    status, (result,), _ = run(capsys, "--evaluate", "runs/whole", "--layouts", "2")
    assert status == 0 and len(result["layouts"]) == 2
    assert result["layouts_mean"] == pytest.approx(sum(result["layouts"]) / 2)

    status, _, errors = run(capsys, *train_it, "--mode", "paper")
    assert status == 2 and "paper mode learns a single layout only" in errors
    status, _, errors = run(capsys, "--evaluate", "runs/whole", "--layouts", "0")
    assert status == 2 and "--layouts: 0 must be from 1 to 1000" in errors


def test_a_scene_file_with_another_formula(here, capsys):
    scene = (ROOT / "scenes/linear/07.toml").read_text(encoding="utf-8")
    (here / "mine.stl.toml").write_text(scene.replace("linear-07", "my plan"), encoding="utf-8")
    formula = "F_[3:50](A2) & G_[0:100](!B1)"
    arguments = ("--train-only", "--scene", "mine.stl.toml", "--formula", formula, "--epochs", "1")
    for out in ("runs/my-plan-tgpo-star-1007", "runs/my-plan-tgpo-star-1007-2"):
        status, lines, _ = run(capsys, *arguments)
        assert status == 0 and lines[-1]["out"] == out and lines[-1]["task"] == "my plan"
    config = json.loads((here / "runs/my-plan-tgpo-star-1007/config.json").read_text())
    assert config["formula"] == formula


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--train-only", "--task", "linear-8"], "task: unknown 'linear-8'. Allowed: linear-08"),
        (["--train-only", "--scene", "no.stl.toml"], "no.stl.toml: cannot be read: No such file"),
        (
            ["--train-only", "--task", "linear-08", "--formula", "F_[0:9](A1) & G_[0:9](!X)"],
            "error: line 1, column 24: unknown name 'X'",
        ),
        (["--train-only", "--task", "linear-08", "--epochs", "0"], "epochs: 0 must be"),
        (["--train-only", "--task", "linear-08", "--time-limit", "nan"], "time_limit: nan must be"),
        (["--resume", "nowhere"], "nowhere: not a run (config.json is missing)"),
        (["--evaluate", "nowhere"], "nowhere: neither a run nor a policy bundle"),
    ],
)
def test_bad_input_leaves_no_trace(here, capsys, arguments, message):
    status, lines, errors = run(capsys, *arguments)
    assert status == 2 and not lines
    assert message in errors and "Traceback" not in errors
    assert not list(here.iterdir())


@pytest.mark.parametrize("action", ["--train-only", "--plan"])
def test_what_is_impossible_is_refused(here, capsys, action):
    arguments = (action, "--task", "linear-08", "--formula", "F_[0:3](A1)")
    status, lines, errors = run(capsys, *arguments)
    assert status == 2 and not lines
    assert "error: impossible: the start to A1 is at least" in errors and "--force" in errors
    assert not list(here.iterdir())


def test_force_trains_and_tells_what_stands_in_the_way(here, capsys):
    train_it = ("--train-only", "--task", "linear-08", "--formula", "F_[0:3](A1)", "--out", "x")
    status, lines, errors = run(capsys, *train_it, "--force", "--epochs", "1")
    assert status == 0 and lines[-1]["success_rate"] == 0.0
    assert "impossible: the start to A1 is at least" in errors
    assert "what stands in the way: Subgoal 1 (A1) fails in 100% of the rollouts" in errors
    status, lines, _ = run(capsys, "--resume", "x", "--epochs", "2")
    assert status == 0 and lines[-1]["epochs"] == 2
    status, lines, _ = run(capsys, "--evaluate", "x")
    assert status == 0 and lines[-1]["success_rate"] == 0.0


def test_doubts_are_told_and_do_not_hinder(here, capsys):
    formula = "F_[0:90](A1) & (!A2) U_[0:80] A2"
    arguments = ("--train-only", "--task", "linear-08", "--formula", formula, "--epochs", "1")
    status, lines, errors = run(capsys, *arguments, "--out", "x")
    assert status == 0 and lines
    assert "warning: A2 and !A2 are wanted at once, which only a boundary allows" in errors


def test_an_unfinished_run_has_no_policy(here, capsys):
    (here / "x").mkdir()
    (here / "x/config.json").write_text("{}")
    status, _, errors = run(capsys, "--evaluate", "x")
    assert status == 2 and "has no policy yet; finish it with --resume x" in errors


def test_a_diverged_training_keeps_what_was_good(here, capsys, monkeypatch):
    def diverging(task, config, state):
        for progress in train(task, config, state):
            if progress.epoch == 3:
                bad = progress.weights._replace(log_std=jnp.full(2, jnp.nan))
                yield replace(progress, weights=bad)
            yield progress

    monkeypatch.setattr(commands, "train", diverging)
    arguments = ("--train-only", "--task", "linear-08", "--target", "2", "--out", "x")
    status, lines, errors = run(capsys, *arguments)
    assert status == 1 and "the training has diverged in epoch 3" in errors
    assert [line["epoch"] for line in lines] == [1, 2]
    assert json.loads((here / "x/summary.json").read_text())["stopped"] == "diverged"
    status, _, _ = run(capsys, "--evaluate", "x")
    assert status == 0


def test_a_full_disk_in_the_middle_is_told_and_can_be_resumed(here, capsys, monkeypatch):
    original = os.fsync

    def full(handle):
        if (here / "x/checkpoints").exists():
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        original(handle)

    arguments = ("--train-only", "--task", "linear-08", "--epochs", "2", "--out", "x")
    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full)
        status, lines, errors = run(capsys, *arguments)
    assert status == 1 and not lines
    assert "cannot be written: No space left on device" in errors and "Traceback" not in errors
    status, lines, _ = run(capsys, "--resume", "x")
    assert status == 0 and lines[-1]["epochs"] == 2


# What the command does, with a small algorithm.
COMMAND = """
import sys
from core.methods.tgpo import method
from tests.small import shrink
original = method.make_algorithm
method.make_algorithm = lambda *given: shrink(original(*given))
from studio.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_ctrl_c_stops_cleanly(tmp_path, disk_cache):
    arguments = ["--train-only", "--task", "linear-08", "--target", "2", "--epochs", "100000"]
    command = [sys.executable, "-c", COMMAND, *arguments, "--out", str(tmp_path / "x")]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=ROOT, stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout is not None
        first = json.loads(process.stdout.readline())
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate()
    assert process.returncode == 0, errors
    last = json.loads(rest.splitlines()[-1])
    assert first["epoch"] == 1 and list(last) == LAST_LINE and last["epochs"] < 100000
    assert json.loads((tmp_path / "x/summary.json").read_text())["stopped"] == "interrupted"
    assert (tmp_path / "x/bundle/step.stablehlo").is_file()
    assert "stopping after this epoch" in errors


# An epoch that takes for ever, in compiled code, where Python's signal handlers do not run.
ENDLESS = """
import jax
from studio.runs.stopping import StopRequest, abort_process
with StopRequest(lambda: print("asked", flush=True), abort_process):
    print("ready", flush=True)
    endless = jax.jit(lambda x: jax.lax.while_loop(lambda y: y > -1, lambda y: y * 0.5, x))
    endless(1.0).block_until_ready()
"""


def test_the_second_signal_aborts_in_the_middle_of_an_epoch():
    command = [sys.executable, "-c", ENDLESS]
    with subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        process.send_signal(signal.SIGINT)
        assert process.stdout.readline() == "asked\n"
        assert process.poll() is None
        process.send_signal(signal.SIGINT)
        assert process.wait() == 130


@pytest.mark.parametrize(
    ("first", "second"), [(signal.SIGINT, signal.SIGTERM), (signal.SIGTERM, signal.SIGINT)]
)
def test_the_first_signal_asks_and_the_second_aborts(first, second):
    asked, aborted = threading.Event(), threading.Event()
    before = signal.getsignal(signal.SIGINT)
    with StopRequest(asked.set, lambda number: aborted.set()) as stop:
        assert not stop.requested
        signal.raise_signal(first)
        assert asked.wait(30) and stop.requested and not aborted.is_set()
        signal.raise_signal(second)
        assert aborted.wait(30)
    assert signal.getsignal(signal.SIGINT) is before


def test_lines_anywhere_but_on_a_terminal(monkeypatch):
    assert isinstance(make_reporter(), LineReporter)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert isinstance(make_reporter(), BarReporter)


def test_the_bar_shows_epoch_success_and_time_left():
    console = Console(force_terminal=True, width=100, file=io.StringIO())
    bar = BarReporter(console)
    bar.begin(TrainingConfig(Algorithm(), epochs=10), 0)
    assert "compiling" in _drawn(bar, console)
    for epoch, success in ((1, None), (2, 0.5), (3, None)):
        line = {"epoch": epoch, "train_seconds": 10.0 * epoch, "success_rate": success}
        bar.report(line | {"diverged": 0})
    text = _drawn(bar, console)
    assert "epoch 3/10" in text and "success 50.0 %" in text and "at most 1:10 left" in text
    bar.restore()


def test_the_bar_promises_no_time_before_the_pace_changes():
    console = Console(force_terminal=True, width=100, file=io.StringIO())
    bar = BarReporter(console)
    bar.begin(TrainingConfig(Algorithm(), epochs=10), 0, change=4)
    line = {"success_rate": None, "diverged": 0}
    for epoch in (1, 2, 3, 4):
        bar.report(line | {"epoch": epoch, "train_seconds": 1.0 * epoch})
        text = _drawn(bar, console)
        assert f"at most {10 - epoch} epochs left" in text and "0:0" not in text
    bar.report(line | {"epoch": 5, "train_seconds": 14.0})
    assert "at most 0:50 left" in _drawn(bar, console)  # 10 s an epoch since the change
    bar.report(line | {"epoch": 6, "train_seconds": 22.0})
    assert "at most 0:36 left" in _drawn(bar, console)
    bar.restore()


def _drawn(bar: BarReporter, console: Console) -> str:
    with console.capture() as captured:
        console.print(bar._progress.get_renderable())
    return captured.get()


@pytest.mark.parametrize(
    ("epoch", "seconds", "first", "began", "limit", "expected"),
    [
        (1, 8.0, 0, 8.0, 1e9, 72.0),  # only one epoch is known
        (3, 12.0, 0, 8.0, 1e9, 14.0),  # the first is slower: 2 s an epoch since
        (3, 12.0, 0, 8.0, 20.0, 8.0),  # the time limit comes first
        (7, 40.0, 5, 38.0, 1e9, 6.0),  # resumed after 5 epochs
        (10, 40.0, 0, 8.0, 1e9, 0.0),
        (5, 40.0, 0, 8.0, 30.0, 0.0),
    ],
)
def test_time_left(epoch, seconds, first, began, limit, expected):
    training = TrainingConfig(Algorithm(), epochs=10, time_limit=limit)
    assert seconds_left(training, epoch, seconds, first, began) == pytest.approx(expected)
