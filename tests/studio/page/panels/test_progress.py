"""The time left, where epochs change their pace (the ant's: first its model, then its physics)."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from core.methods.tgpo.algorithm import make_algorithm
from core.methods.training import TrainingConfig
from scenes import load_task
from studio.page.panels.progress import eta
from studio.page.trainer import Phase, Point, Training
from studio.runs.tasks import build_task

CHANGE, FAST, SLOW = 50, 0.08, 0.8
"""Last epoch of the fast pace, and seconds of a fast and of a slow epoch."""


def training(
    epoch: int, *, change: int | None = CHANGE, began: int = 0, limit: float = 1e9
) -> Training:
    """A training of 100 epochs that has come to an epoch, since it was last resumed at `began`."""

    def seconds(number: int) -> float:
        fast = number if change is None else min(number, change)
        return FAST * fast + SLOW * (number - fast)

    learner = SimpleNamespace(pace_change=change)
    config = SimpleNamespace(epochs=100, time_limit=limit, learner=lambda task: learner)
    return Training(
        Phase.TRAINING,
        cast(Any, "task"),
        cast(Any, config),
        epoch=epoch,
        seconds=seconds(epoch),
        curve=tuple(Point(n, 0.0, 0.0, seconds=seconds(n)) for n in range(1, epoch + 1)),
        began_epoch=began,
        began_seconds=seconds(began),
    )


@pytest.mark.parametrize("epoch", [1, 49, 50])
def test_nothing_is_promised_before_the_pace_changes(epoch):
    assert eta(training(epoch)) is None


@pytest.mark.parametrize("epoch", [51, 52, 99])
def test_right_after_it_the_new_pace_counts(epoch):
    assert eta(training(epoch)) == pytest.approx(SLOW * (100 - epoch))
    assert eta(training(epoch, began=30)) == pytest.approx(SLOW * (100 - epoch))


def test_the_time_limit_comes_first():
    assert eta(training(60, limit=15.0)) == pytest.approx(15.0 - (FAST * 50 + SLOW * 10))


@pytest.mark.parametrize("change", [None, 100, 10**6])
def test_where_the_pace_stays_it_is_known_from_the_first_epoch(change):
    assert eta(training(1, change=change)) == pytest.approx(FAST * 99)


def test_a_training_resumed_after_the_change_is_timed_at_once():
    assert eta(training(61, began=60)) == pytest.approx(SLOW * 39)


@pytest.mark.parametrize(("task", "expected"), [("linear-08", None), ("ant-demo", 50)])
def test_the_learner_says_when_the_pace_changes(task, expected):
    built = build_task(load_task(task))
    algorithm = make_algorithm("studio", "tgpo-star", built.robot)
    shown = Training(Phase.TRAINING, built, TrainingConfig(algorithm))
    assert shown.pace_change == expected
