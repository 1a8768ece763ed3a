"""What the panel says of simulated cells, and which cell a click on them means."""

from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import MagicMock

import numpy as np
import pytest

from core.heatmap import Heatmap
from core.methods.tgpo.method import TgpoLearner
from core.truth import nothing_simulated
from studio.page.analyst import Analyst
from studio.page.panels.heatmap import HeatmapPanel, _clicked_cell, clicked_schedule
from studio.page.panels.truth import press, switch_html, truth_keys, truth_line, truth_of
from studio.page.picture import MapView, Picture, Simulated, draw_picture
from studio.page.subject import Subject
from studio.page.trainer import Training


def make(first, second):
    """A picture over two times, of any subject."""
    values = np.arange(float(first * second)).reshape(second, first)
    schedule = np.zeros(8, np.int32)
    heatmap = Heatmap(
        (0, 1), np.arange(first), np.arange(second), values, np.zeros_like(values), schedule
    )
    return Picture(cast(Any, None), heatmap, (0, 0))


def test_the_line_counts_and_correlates():
    truth = nothing_simulated(make(3, 2).heatmap)
    assert truth_line(truth) == "Simulating 6 schedules…"
    part = truth._replace(robustness=np.array([[-1.0, np.nan, -2], [3, np.nan, 0]]))
    assert truth_line(part) == (
        "Simulated: 2 of 4 (2 to come) schedules satisfy the formula; "
        "rank correlation with the critic 0.60."
    )
    flat = truth._replace(robustness=np.full((2, 3), -1.0))
    assert truth_line(flat) == "Simulated: 0 of 6 schedules satisfy the formula."


def test_the_keys_count_the_crosses():
    truth = nothing_simulated(make(3, 2).heatmap)
    fine = truth._replace(robustness=np.array([[-1.0, -1, -1], [-1, 1, 1]]))
    assert len(truth_keys(fine)) == 2
    wrong = truth._replace(robustness=np.array([[1.0, -1, -1], [-1, 1, -1]]))
    assert "(2)" in truth_keys(wrong)[2]


def test_a_click_means_the_cell_that_was_simulated():
    picture = make(60, 50)
    truth = nothing_simulated(picture.heatmap)
    script = _clicked_cell(picture, truth)
    assert script == f"'0,1 '+{truth.columns.tolist()}[column]+' '+{truth.rows.tolist()}[row]"
    schedule = clicked_schedule(picture, f"0,1 {truth.columns[7]} {truth.rows[20]}")
    assert schedule == tuple(truth.schedules[20, 7, :2])


def test_cells_of_another_picture_are_not_shown():
    one, other = make(3, 2), make(3, 2)
    known = nothing_simulated(one.heatmap)._replace(robustness=np.ones((2, 3)))
    analyst: Any = SimpleNamespace(simulating=True, simulated=Simulated(one, known))
    assert truth_of(analyst, one) is known
    unknown = truth_of(analyst, other)
    assert unknown is not None and not unknown.simulated.any()
    analyst.simulating = False
    assert truth_of(analyst, one) is None


@pytest.mark.parametrize(("value", "then"), [("simulated", [True]), ("critic", [False]), ("x", [])])
def test_the_switch(value, then):
    told: list[bool] = []
    press(cast(Analyst, SimpleNamespace(simulate=told.append)), value)
    assert told == then


def test_the_pressed_side_is_marked():
    clicks: Any = SimpleNamespace(script=lambda value: f"send({value})")
    html = switch_html(clicks, simulating=True)
    assert html.index('aria-pressed="false"') < html.index("Critic")
    assert html.index("Critic") < html.index('aria-pressed="true"') < html.index("Simulated")


def test_the_panel_follows_each_batch(linear_task, small_algorithm):
    learner = TgpoLearner(linear_task, small_algorithm)
    controller = learner.controller(learner.fresh(0).parameters)
    picture = draw_picture(Subject(object(), linear_task, controller, 1), MapView(), None)
    panel, shown = HeatmapPanel(MagicMock(), MagicMock()), []
    panel._options, panel._map = MagicMock(), cast(Any, SimpleNamespace(show=shown.append))
    analyst = SimpleNamespace(
        picture=picture, stale="", view=MapView(), simulating=True, simulated=None
    )
    session: Any = SimpleNamespace(
        analyst=analyst,
        subject=Training(task=linear_task),
        player=SimpleNamespace(recording=None),
    )
    panel.draw(session)
    assert "Simulating 576 schedules…" in shown[-1]
    truth = nothing_simulated(picture.heatmap)
    for known in (3, 5):
        robustness = truth.robustness.copy()
        robustness.ravel()[:known] = 1.0
        analyst.simulated = Simulated(picture, truth._replace(robustness=robustness))
        panel.draw(session)
        assert f"{known} of {known} ({576 - known} to come)" in shown[-1]
    analyst.simulating = False
    panel.draw(session)
    assert "to come" not in shown[-1] and "<svg" in shown[-1]
