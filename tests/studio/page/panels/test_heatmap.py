from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import MagicMock

import numpy as np
import pytest

from core.heatmap import Heatmap
from core.methods.tgpo.method import TgpoLearner
from scenes import load_task
from studio.page.panels.heatmap import HeatmapPanel, awaited, clicked_schedule
from studio.page.picture import MapView, draw_picture
from studio.page.subject import Subject
from studio.page.trainer import Phase, Training
from studio.runs.recording import record
from studio.runs.tasks import build_task


@pytest.fixture
def picture() -> Any:
    heatmap = Heatmap(
        (0, 2),
        np.arange(5, 9),
        np.arange(20, 23),
        np.zeros((3, 4)),
        np.zeros((3, 4)),
        np.array([6, 7, 21, 0, 0, 0, 0, 0]),
    )
    return cast(Any, SimpleNamespace(heatmap=heatmap, choice=(6, 7, 21)))


def test_a_cell_becomes_its_schedule(picture):
    assert clicked_schedule(picture, "0,2 3 1") == (8, 7, 21)
    assert clicked_schedule(picture, "0,2 0 2") == (5, 7, 22)


@pytest.mark.parametrize(
    "value",
    ["", "0,2", "0,1 0 0", "0,2 4 0", "0,2 0 3", "0,2 -1 0", "0,2 1", "0,2 1 1 1", "0,2 a b",
     "0,2 1e1 0", "0,2 99999999999999999999 0", "0,2 ² 0"],
)  # fmt: skip
def test_what_is_no_cell_of_this_map_is_ignored(picture, value):
    assert clicked_schedule(picture, value) is None


@pytest.fixture
def fewer():
    """linear-08 before its formula had three times."""
    return build_task(load_task("linear-08"), "F_[0:90](A1)")


def resting(task, schedule):
    """A recording of a robot that does not move."""
    steps = task.padded_horizon
    states, actions = np.zeros((steps + 1, 2)), np.zeros((steps, 2))
    return record(task, schedule, states, actions, np.full((steps + 1, 32), -1.0))


def test_the_map_does_not_mark_the_schedule_of_an_earlier_formula(
    linear_task, fewer, small_algorithm
):
    learner = TgpoLearner(linear_task, small_algorithm)
    controller = learner.controller(learner.fresh(0).parameters)
    picture = draw_picture(Subject(object(), linear_task, controller, 1), MapView(), None)
    panel, shown = HeatmapPanel(MagicMock(), MagicMock()), []
    panel._options, panel._map = MagicMock(), cast(Any, SimpleNamespace(show=shown.append))
    session: Any = SimpleNamespace(
        analyst=SimpleNamespace(
            picture=picture, stale="", view=MapView(), simulating=False, simulated=None
        ),
        subject=Training(task=linear_task),
        player=SimpleNamespace(recording=resting(fewer, (20,))),
    )
    panel.draw(session)
    one_mark = shown[-1].count("<circle")
    session.player.recording = resting(linear_task, (20, 50, 15))
    panel.draw(session)
    assert shown[-1].count("<circle") == 2 * one_mark > 0


def test_a_click_on_the_map_of_an_earlier_formula_is_ignored(linear_task, fewer, picture):
    asked: list[tuple[int, ...]] = []
    picture.subject = SimpleNamespace(task=linear_task)
    session: Any = SimpleNamespace(
        analyst=SimpleNamespace(picture=picture, ask=asked.append),
        subject=Training(task=fewer),
    )
    panel = HeatmapPanel(MagicMock(), session)
    panel._click("0,2 3 1")
    assert asked == []
    session.subject = Training(task=linear_task)
    panel._click("0,2 3 1")
    assert asked == [(8, 7, 21)]


def test_what_is_awaited_before_there_is_a_map():
    weights = object()
    assert awaited(Training(Phase.LOADED, weights=weights)) == "Being drawn…"
    assert awaited(Training(Phase.TRAINING, weights=weights)) == "Being drawn…"
    assert awaited(Training(Phase.COMPILING)) == "Shown after the first epoch…"
    assert awaited(Training()) == "Appears in training."
