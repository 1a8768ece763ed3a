"""The analyst with real, untrained networks."""

import numpy as np
import pytest

from core.algorithm import Algorithm
from core.heatmap import Heatmap
from core.programs import fresh_learner
from core.training import TrainingConfig
from scenes import load_task
from studio.analyst import Analyst, best_cell, default_axes, initial_state
from studio.tasks import build_task
from studio.worker import Stage, Training
from tests.studio.waiting import wait_for


@pytest.fixture(scope="module")
def training(linear_task, small_algorithm):
    learner = fresh_learner(linear_task, small_algorithm, seed=0)
    config = TrainingConfig(small_algorithm)
    return Training(Stage.TRAINING, linear_task, config, epoch=3, parameters=learner.parameters)


@pytest.fixture(scope="module")
def analyst(training):
    analyst = Analyst()
    analyst.observe(training)
    yield analyst
    analyst.close()


def rolled_out(analyst, schedule):
    before = analyst.recording
    analyst.ask(schedule)
    assert wait_for(lambda: analyst.recording is not before, 120), analyst.error
    return analyst.recording


def test_the_first_two_times_are_drawn(analyst, linear_task):
    assert wait_for(lambda: analyst.picture is not None, 120), analyst.error
    picture = analyst.picture
    assert picture.heatmap.axes == (0, 1)
    assert picture.subject.epoch == 3
    assert np.isfinite(picture.heatmap.values).all()
    variables = linear_task.grounding.decomposition.variables
    assert all(v.low <= t <= v.high for v, t in zip(variables, picture.choice, strict=True))


def test_the_choice_is_the_best_cell(analyst):
    assert wait_for(lambda: analyst.picture is not None, 120), analyst.error
    picture = analyst.picture
    score = picture.heatmap.values - 10 * picture.heatmap.shortfall
    row, column = np.unravel_index(score.argmax(), score.shape)
    assert picture.choice == tuple(picture.heatmap.schedule_at(row, column)[:3])


def test_broken_values_are_not_chosen():
    map_ = Heatmap(
        (0,),
        np.arange(3),
        np.zeros(1, np.int32),
        np.array([[1.0, np.nan, 5.0]]),
        np.array([[0.0, 0.0, 0.5]]),
        np.zeros(8, np.int32),
    )
    assert best_cell(map_, Algorithm(prune=True))[0] == 0
    assert best_cell(map_, Algorithm(prune=False))[0] == 2


def test_times_of_branches_not_taken_are_not_offered_first():
    scene = load_task("linear-07")
    task = build_task(scene, "F_[0:40](A1 & F_[0:50](A2)) | F_[0:60](G_[0:10](A2))")
    names = [variable.name for variable in task.grounding.decomposition.variables]
    assert names == ["b1", "t1", "t2", "t3"]
    assert default_axes(task, (0, 5, 5, 5)) == (1, 2)
    assert default_axes(task, (1, 5, 5, 5)) == (3,)


def test_other_axes_can_be_chosen(analyst):
    analyst.choose_axes((2, 0))
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


def test_without_a_schedule_the_critic_chooses(analyst):
    assert rolled_out(analyst, None).schedule == analyst.picture.choice


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
    assert analyst.recording is None
