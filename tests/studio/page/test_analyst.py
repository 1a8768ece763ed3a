"""The analyst with real, untrained networks."""

from dataclasses import replace

import jax
import numpy as np
import pytest

from core.heatmap import Heatmap
from core.methods import METHODS
from core.methods.training import TrainingConfig
from scenes import load_task
from studio.page import asking
from studio.page.analyst import STARTS, Analyst
from studio.page.picture import MapView, best_cell, default_axes
from studio.page.trainer import Phase, Training
from studio.runs.tasks import build_task, initial_state
from tests.studio.waiting import Gate, wait_for


@pytest.fixture(scope="module")
def training(linear_task, small_algorithm):
    learner = METHODS["tgpo-star"].learner(linear_task, small_algorithm)
    weights = learner.weights(learner.fresh(seed=0))
    config = TrainingConfig(small_algorithm)
    return Training(Phase.TRAINING, linear_task, config, epoch=3, weights=weights)


@pytest.fixture(scope="module")
def analyst(training):
    analyst = Analyst()
    analyst.observe(training)
    yield analyst
    analyst.close()


def rolled_out(analyst, schedule):
    before = analyst.answer
    analyst.ask(schedule)
    assert wait_for(lambda: analyst.answer is not before), analyst.error
    return analyst.answer.recordings[0]


def test_the_first_two_times_are_drawn(analyst, linear_task):
    assert wait_for(lambda: analyst.picture is not None), analyst.error
    picture = analyst.picture
    assert picture.heatmap.axes == (0, 1)
    assert picture.subject.epoch == 3
    assert np.isfinite(picture.heatmap.values).all()
    variables = linear_task.grounding.decomposition.variables
    assert all(v.low <= t <= v.high for v, t in zip(variables, picture.choice, strict=True))


def test_the_choice_is_the_best_cell(analyst):
    assert wait_for(lambda: analyst.picture is not None), analyst.error
    picture = analyst.picture
    values = picture.heatmap.values
    row, column = np.unravel_index(values.argmax(), values.shape)
    assert picture.choice == tuple(picture.heatmap.schedule_at(row, column)[:3])


def test_broken_values_are_not_chosen():
    map_ = Heatmap(
        (0,),
        np.arange(3),
        np.zeros(1, np.int32),
        np.array([[1.0, np.nan, 5.0]]),
        np.zeros((1, 3)),
        np.zeros(8, np.int32),
    )
    assert best_cell(map_)[0] == 2


def test_times_of_branches_not_taken_are_not_offered_first():
    scene = load_task("linear-07")
    task = build_task(scene, "F_[0:40](A1 & F_[0:50](A2)) | F_[0:60](G_[0:10](A2))")
    names = [variable.name for variable in task.grounding.decomposition.variables]
    assert names == ["b1", "t1", "t2", "t3"]
    assert default_axes(task, (0, 5, 5, 5)) == (1, 2)
    assert default_axes(task, (1, 5, 5, 5)) == (3,)


def test_other_axes_can_be_chosen(analyst):
    analyst.choose_view(MapView(axes=(2, 0)))
    assert wait_for(lambda: analyst.picture is not None and analyst.picture.heatmap.axes == (2, 0))
    assert analyst.picture.heatmap.first.tolist() == list(range(10, 21))


def test_a_schedule_is_rolled_out_from_the_centre(analyst, linear_task):
    recording = rolled_out(analyst, (20, 50, 15))
    assert recording.schedule == (20, 50, 15)
    np.testing.assert_allclose(recording.states[0], initial_state(linear_task), atol=1e-6)
    np.testing.assert_allclose(recording.states[0], (-3, -3), atol=1e-6)


def test_schedules_make_a_difference(analyst):
    one, other = rolled_out(analyst, (20, 50, 15)), rolled_out(analyst, (80, 45, 10))
    assert np.abs(one.states - other.states).max() > 1e-4


def test_without_a_schedule_a_plan_is_found_and_the_map_shows_it(analyst):
    plan = rolled_out(analyst, None)
    found = analyst.answer
    assert found.seconds > 0
    assert plan.robustness == max(one.robustness for one in (plan, *found.alternatives))
    rest = [index for index in range(3) if index not in analyst.picture.heatmap.axes]

    def on_the_map():
        held = analyst.picture.heatmap.schedule
        return all(held[index] == plan.schedule[index] for index in rest)

    assert wait_for(on_the_map, 30), analyst.error


def test_the_share_of_random_starts_is_counted(analyst):
    rolled_out(analyst, None)
    assert wait_for(lambda: analyst.share is not None and analyst.share.starts >= STARTS)
    assert 0 <= analyst.share.succeeded <= analyst.share.starts
    assert analyst.share.subject is analyst.answer.subject


def test_an_error_is_kept_and_the_next_question_answered(analyst, capsys):
    analyst.ask(("no", "number", "here"))
    assert wait_for(lambda: analyst.error != "")
    assert not analyst.busy
    rolled_out(analyst, (20, 50, 15))
    assert analyst.error == ""


def test_before_any_weights_nothing_is_answered():
    analyst = Analyst()
    analyst.observe(Training())
    analyst.ask((1, 2, 3))
    assert not analyst.busy
    analyst.close()
    assert analyst.answer is None


def test_a_request_outlives_a_change_of_weights(training, monkeypatch):
    """A click whose answer came from weights that no longer answer is asked of the new ones."""
    gate = Gate(asking.rolled_out)
    monkeypatch.setattr("studio.page.analyst.rolled_out", gate)
    analyst = Analyst()
    try:
        analyst.observe(training)
        analyst.ask((3, 50, 12))
        assert gate.entered.acquire(timeout=120)
        after = replace(
            training, identity=object(), weights=jax.tree.map(lambda leaf: leaf, training.weights)
        )
        analyst.observe(after)
        analyst.ask(asked=False)  # a plan that nobody pressed a button for
        gate.open.release(2)
        assert wait_for(lambda: analyst.answer is not None), analyst.error
        answer = analyst.answer
        assert answer is not None
        assert answer.subject.training is after.identity
        assert answer.recordings[0].schedule[:3] == (3, 50, 12)
    finally:
        gate.open.release(9)
        analyst.close()
