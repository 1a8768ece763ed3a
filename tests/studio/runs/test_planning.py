"""`--plan` and `--pretrain` from the command line, with small networks."""

import json
from dataclasses import replace

import pytest

from core.methods import METHODS
from core.methods.tgpo.algorithm import many_missions
from scenes import load_task
from scenes.missions import HELD_OUT, TRAINED
from studio.runs import held_out, missions, outcomes, pretraining
from studio.runs.bundle import load_bundle
from studio.runs.json_documents import algorithm_document
from studio.runs.pretrained import FORMAT, Card, load_weights, save_weights
from studio.runs.tasks import build_task
from tests.small import shrink
from tests.studio.runs.test_commands import here, run

__all__ = ["here"]

FIELDS = [
    *("task", "satisfied", "success_rate", "robustness", "nudged", "between"),
    "between_rate",
    *("schedule", "alternatives"),
    *("answer_seconds", "compile_seconds", "weights"),
]


@pytest.fixture(scope="module")
def weights(tmp_path_factory, linear_task, small_algorithm):
    """A file of untrained weights for Linear."""
    learner = METHODS["tgpo"].learner(linear_task, small_algorithm)
    card = Card(
        format=FORMAT,
        robot="linear",
        mode="studio",
        method="tgpo",
        seed=3,
        epochs=7,
        env_steps=0,
        train_seconds=0.0,
        families=(),
        held_out=(),
        algorithm=algorithm_document(small_algorithm),
    )
    path = tmp_path_factory.mktemp("weights") / "linear.safetensors"
    save_weights(path, learner.weights(learner.fresh(0)), card)
    return path


def test_a_plan_is_one_line(here, capsys, weights):
    plan = ("--plan", "--task", "linear-08", "--weights", str(weights), "--starts", "5")
    status, (line,), _ = run(capsys, *plan)
    assert status == 0
    assert list(line) == FIELDS
    assert line["satisfied"] == (line["robustness"] >= 0)
    assert list(line["schedule"]) == ["t1", "t2", "t3"]
    assert line["success_rate"] * 5 == pytest.approx(round(line["success_rate"] * 5))
    status, (again,), _ = run(capsys, *plan)
    assert [again[name] for name in FIELDS[:8]] == [line[name] for name in FIELDS[:8]]


def test_a_plan_leaves_a_bundle(here, capsys, weights):
    plan = ("--plan", "--task", "linear-07", "--weights", str(weights), "--out", "b")
    status, (line,), _ = run(capsys, *plan)
    assert status == 0 and line["out"] == "b"
    policy = load_bundle(here / "b")
    assert (policy.scene.name, policy.seed, policy.epochs) == ("linear-07", 3, 7)
    assert policy.success_rate == line["success_rate"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--plan", "--task", "linear-08", "--weights", "no.safetensors"), "no.json"),
        (("--plan", "--task", "linear-08", "--weights", "none"), "there are none for linear"),
        (("--plan", "--task", "linear-08", "--starts", "0"), "--starts: 0 must be"),
        (("--plan", "--task", "linear-08", "--epochs", "3"), "--epochs cannot be used"),
        (("--pretrain", "bicycle"), "robot: unknown 'bicycle'"),
        (("--pretrain", "linear", "--task", "linear-08"), "--task cannot be used"),
    ],
)
def test_what_cannot_be_done_is_said(here, capsys, arguments, message):
    status, lines, errors = run(capsys, *arguments)
    assert status == 2 and not lines
    assert message in errors and "Traceback" not in errors


def test_weights_of_another_robot_are_refused(here, capsys, weights):
    arguments = ("--plan", "--task", "unicycle-08", "--weights", str(weights))
    status, _, errors = run(capsys, *arguments)
    assert status == 2 and "weights of the robot 'linear', but the task is for" in errors


def test_a_training_begins_with_weights_and_remembers_which(here, capsys, weights):
    begin = ("--train-only", "--task", "linear-08", "--weights", str(weights), "--target", "2")
    status, lines, _ = run(capsys, *begin, "--epochs", "2", "--out", "whole")
    assert status == 0
    config = json.loads((here / "whole/config.json").read_text())
    assert config["weights"] == str(weights)
    run(capsys, *begin, "--epochs", "1", "--out", "part")
    status, resumed, _ = run(capsys, "--resume", "part", "--epochs", "2")
    assert status == 0 and resumed[0]["batch_return"] == lines[1]["batch_return"]
    scratch = ("--train-only", "--task", "linear-08", "--weights", "none", "--target", "2")
    _, other, _ = run(capsys, *scratch, "--epochs", "1", "--out", "scratch")
    assert other[0]["batch_return"] != lines[0]["batch_return"]


@pytest.fixture
def small_pretraining(monkeypatch, here):
    """Few missions, small networks, little measured."""

    def small(algorithm, epochs):
        return replace(shrink(many_missions(algorithm, epochs)), layouts=4, fresh_layouts=1)

    monkeypatch.setattr(pretraining, "many_missions", small)
    monkeypatch.setattr(missions, "VALIDATIONS", 1)
    monkeypatch.setattr(outcomes, "MISSIONS", 16)
    monkeypatch.setattr(held_out, "HELD_OUT", HELD_OUT[:1])
    monkeypatch.setattr(held_out, "SHIPPED_HELD_OUT", ("05",))
    return here


def test_weights_are_trained_resumed_and_used(small_pretraining, capsys):
    folder = small_pretraining
    status, lines, _ = run(capsys, "--pretrain", "linear", "--epochs", "2", "--out", "whole")
    assert status == 0
    card = lines[-1]
    assert card["families"] == [*TRAINED, "shipped"]
    assert [row["name"] for row in card["held_out"]] == ["formulas", HELD_OUT[0]]
    assert card["out"] == "whole/weights.safetensors"

    task = build_task(load_task("linear-08"))
    assert load_weights(folder / "whole/weights.safetensors", task).card.epochs == 2
    plan = ("--plan", "--task", "linear-08", "--weights", "whole/weights.safetensors")
    status, (line,), _ = run(capsys, *plan)
    assert status == 0 and line["weights"] == "whole/weights.safetensors"
