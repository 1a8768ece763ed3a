"""`--exact` from the command line."""

import json
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

from scenes import load_task
from tests.studio.runs.test_commands import ROOT, here, run
from tests.tools.witness import judge

__all__ = ["here"]

FORMULA = "F_[0:20](A1) & G_[0:20](!B)"
FIELDS = ["task", "formula", "start", "status", "robustness", "bound", "seconds"]


def test_a_plan_is_one_line_and_a_file(here, capsys):
    arguments = ("--exact", "--task", "linear-demo", "--formula", FORMULA, "--out", "plan.json")
    status, (line,), _ = run(capsys, *arguments)
    assert status == 0
    assert list(line) == [*FIELDS, "out"]
    assert (line["status"], line["start"]) == ("optimal", [-3.3, -3.3])
    kept = json.loads((here / "plan.json").read_text())
    assert {name: kept[name] for name in FIELDS} == {name: line[name] for name in FIELDS}
    scene = load_task("linear-demo")
    assert len(kept["actions"]) == scene.horizon
    assert len(kept["positions"]) == scene.horizon + 1
    replayed = judge(replace(scene, formula=FORMULA), kept["start"], kept["actions"])
    assert replayed == pytest.approx(line["robustness"], abs=1e-4)


def test_what_cannot_be_satisfied_is_proved(here, capsys):
    arguments = ("--exact", "--task", "linear-demo", "--formula", "F_[0:3](A1)")
    status, (line,), _ = run(capsys, *arguments)
    assert (status, line["status"]) == (0, "infeasible")
    assert line["robustness"] is None and line["bound"] is None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--exact", "--task", "ant-demo"), "exact plans are for robots whose action"),
        (("--exact", "--task", "linear-demo", "--time-limit", "0"), "--time-limit: 0.0 must be"),
        (("--exact", "--task", "linear-demo", "--seed", "3"), "--seed cannot be used with --exact"),
    ],
)
def test_what_cannot_be_used_is_refused(here, capsys, arguments, message):
    status, lines, errors = run(capsys, *arguments)
    assert (status, lines) == (2, [])
    assert message in errors


# Says when the solver begins with the schedules, and when it has left them.
TELLING = """
import sys
from core.planning import program
run = program._Solver.run
def told(solver):
    if solver.getNumCol() < 1000:
        return run(solver)
    print("solving", flush=True)
    status = run(solver)
    print("ended", flush=True)
    return status
program._Solver.run = told
from studio.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_ctrl_c_ends_the_search_and_then_the_process():
    # linear-05 takes the solver seconds; a process that ends in the middle of it crashes.
    command = [sys.executable, "-c", TELLING, "--exact", "--task", "linear-05"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=ROOT, stdout=pipe, stderr=pipe, text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "solving\n"
        process.send_signal(signal.SIGINT)
        rest, errors = process.communicate()
    assert (process.returncode, rest, errors) == (130, "ended\n", "aborted\n")
