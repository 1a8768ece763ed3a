"""A method without schedules: no map, with the reason; rollouts as for any other."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, cast
from unittest.mock import MagicMock

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.controller import NO_SCHEDULES
from core.errors import UserError
from core.settled import times_met
from studio.page import picture as module
from studio.page.analyst import Analyst
from studio.page.asking import SAMPLE
from studio.page.files.keeping import heatmap_file
from studio.page.panels.heatmap import HeatmapPanel
from studio.page.picture import MapView
from studio.page.subject import Subject
from studio.page.trainer import Training
from studio.runs.tasks import initial_state
from tests.studio.waiting import wait_for


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Reactive:
    """Always moves the same way; knows no schedules."""

    action: jax.Array

    search = None

    @property
    def attempts(self):
        return (self,)

    def score(self, problem, state, schedule):
        return jnp.zeros(())

    def start(self, problem, state, schedule):
        return jnp.zeros(())

    def step(self, problem, memory, state):
        return memory, self.action


@pytest.fixture(scope="module")
def subject(linear_task):
    return Subject(object(), linear_task, Reactive(jnp.array([0.1, -0.1])), 3)


@pytest.fixture(scope="module")
def picture(subject):
    return module.draw_picture(subject, MapView(), None)


@pytest.fixture
def panel():
    """The panel, with the options that it was told to show."""
    panel = HeatmapPanel(MagicMock(), MagicMock())
    panel._options = MagicMock()
    return panel


def shown(panel, picture):
    """What the panel shows of a picture."""
    html = []
    panel._map = SimpleNamespace(show=html.append)
    session = SimpleNamespace(
        analyst=SimpleNamespace(
            picture=picture, stale="", view=MapView(), simulating=False, simulated=None
        ),
        subject=Training(task=picture.subject.task),
        player=SimpleNamespace(recording=None),
    )
    panel.draw(cast(Any, session))
    return html[-1]


def test_all_its_times_are_zero(subject, picture):
    assert module._choice(subject, initial_state(subject.task)) == (0, 0, 0)
    assert len(picture.choice) == 3
    assert not picture.heatmap.values.any()


def test_no_map_is_shown_but_the_reason(panel, picture):
    html = shown(panel, picture)
    assert NO_SCHEDULES in html
    assert "<svg" not in html
    panel._options.show.assert_called_once_with(None)  # no axes to choose either


def test_a_method_with_schedules_has_its_map(panel, picture):
    searched = SimpleNamespace(search=object())
    other = module.Picture(
        picture.subject._replace(controller=cast(Any, searched)), picture.heatmap, picture.choice
    )
    html = shown(panel, other)
    assert NO_SCHEDULES not in html
    assert "<svg" in html
    panel._options.show.assert_called_once_with(other)


def test_there_is_no_map_to_export(picture):
    player = SimpleNamespace(recording=None)
    session = SimpleNamespace(analyst=SimpleNamespace(picture=picture), player=player)
    with pytest.raises(UserError, match=NO_SCHEDULES):
        heatmap_file(cast(Any, session))


def test_it_is_rolled_out(linear_task, subject):
    analyst = Analyst()
    analyst.watched = False
    config = SimpleNamespace(controller=lambda weights: subject.controller)
    training = Training(task=linear_task, config=cast(Any, config), weights="weights")
    analyst.observe(training)
    analyst.ask()
    assert wait_for(lambda: analyst.answer is not None), analyst.error
    assert analyst.answer is not None
    (recording,) = analyst.answer.recordings
    assert recording.schedule == times_met(linear_task, recording.margins)
    moved = np.diff(recording.states[:, 0])[:5]
    assert (moved > 0).all() and np.ptp(moved) < 1e-5
    analyst.ask_sample()
    assert wait_for(lambda: analyst.sample is not None), analyst.error
    assert analyst.sample is not None and len(analyst.sample.recordings) == SAMPLE
    assert analyst.close()
