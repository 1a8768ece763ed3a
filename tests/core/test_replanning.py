"""Planning anew after a jump: what is kept, what is chosen anew, and when nothing helps."""

from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest

from core.controller import Controller, pad_schedule
from core.errors import UserError
from core.evaluation import trace_robustness
from core.methods import METHODS
from core.replanning import Past, replan
from core.rollout import roll_on, roll_out
from core.settled import left_open, reopened, settled_by_chance, settled_by_schedule
from scenes import load_task
from studio.runs.tasks import build_task, initial_state
from tests.core.test_answer import Reactive, Seeker, Squinting

STAY = "F_[0:40](G_[0:10](A1)) & F_[0:60](A2)"
FAR, INSIDE_B = (-4.5, 4.5), (0.3, 0.3)
SEEKER = Seeker(jnp.ones(()))


@pytest.fixture(scope="module")
def task(disk_cache):
    return build_task(load_task("linear-demo"), "F_[0:60](A1) & F_[0:60](A2)")


@pytest.fixture(scope="module")
def guarded(disk_cache):
    """With an obstacle that is forbidden late."""
    formula = "F_[0:60](A1) & F_[0:60](A2) & G_[31:60](!B)"
    return build_task(load_task("linear-demo"), formula)


@pytest.fixture(scope="module")
def stay(disk_cache):
    return build_task(load_task("linear-demo"), STAY)


def trace(task, schedule, controller: Controller = SEEKER):
    """States and actions of a schedule's rollout."""
    rows = pad_schedule(task.problem, jnp.asarray(schedule, jnp.int32))[None]
    rollout = roll_out(task, controller, initial_state(task)[None], rows)
    return np.asarray(rollout.states)[:, 0], np.asarray(rollout.actions)[:, 0]


def jump(task, schedule, step, place=None):
    """The past of a rollout whose robot is put somewhere else at a step."""
    states, actions = trace(task, schedule)
    states = np.array(states[: step + 1])
    if place is not None:
        states[step] = place
    return Past(states, actions[:step])


def center(task, name):
    """Middle of a region [2]."""
    index = [goal.predicate.name for goal in task.grounding.subgoals].index(name)
    return np.asarray(task.problem.center[index])


def without(task, past, schedule):
    """Robustness of going on as planned."""
    step = len(past.states) - 1
    rest = np.repeat(past.states[-1:], task.padded_horizon - step, 0)
    long = np.concatenate([past.states, rest])[:, None]
    rows = np.asarray(pad_schedule(task.problem, jnp.asarray(schedule, jnp.int32)))[None]
    rollout = roll_on(task, SEEKER, long, np.array([step]), rows)
    return trace_robustness(task, np.asarray(rollout.margins))[0]


def test_a_jump_that_leaves_time_fails_as_planned_and_succeeds_anew(task):
    schedule = (20, 34)
    past = jump(task, schedule, 24, FAR)
    assert without(task, past, schedule) < 0
    found = replan(task, SEEKER, past, schedule)
    assert found.plan.satisfied and found.falsified is None
    assert found.plan.schedule[0] == 20  # A1 was met: it stays met
    assert 24 < found.plan.schedule[1] <= 60
    np.testing.assert_array_equal(found.plan.states[:25], past.states)
    np.testing.assert_array_equal(found.plan.actions[:24], past.actions)
    assert found.plan.robustness == trace_robustness(task, found.plan.margins[:, None])[0]


def test_no_time_left_is_a_miss_but_no_proof(task):
    schedule = (50, 60)
    found = replan(task, SEEKER, jump(task, schedule, 55, FAR), schedule)
    assert not found.plan.satisfied and found.falsified is None
    assert replan(task, SEEKER, jump(task, schedule, 55), schedule).plan.satisfied


def test_a_jump_into_an_obstacle_is_proved_hopeless(guarded):
    past = jump(guarded, (20, 30), 32, INSIDE_B)
    found = replan(guarded, SEEKER, past, (20, 30))
    assert found.falsified == 32 and not found.plan.satisfied
    found = replan(guarded, SEEKER, jump(guarded, (20, 30), 32), (20, 30))
    assert found.falsified is None


def test_a_stay_that_has_begun_goes_on(stay):
    schedule = (20, 50)
    inside = center(stay, "A1") + np.array([0.1, 0.0], np.float32)
    found = replan(stay, SEEKER, jump(stay, schedule, 25, inside), schedule)
    assert found.plan.satisfied and found.plan.schedule[0] == 20


def test_a_stay_that_is_broken_begins_anew(stay):
    schedule = (20, 50)
    outside = center(stay, "A1") + np.array([2.0, 0.0], np.float32)
    past = jump(stay, schedule, 25, outside)
    assert without(stay, past, schedule) < 0
    found = replan(stay, SEEKER, past, schedule)
    assert found.plan.satisfied and 25 < found.plan.schedule[0] <= 40


def test_what_was_met_unasked_counts(task):
    """A1 was passed at step 20 although it was due at 55."""
    rows = pad_schedule(task.problem, jnp.array([20, 40]))[None]
    rollout = roll_out(task, SEEKER, initial_state(task)[None], rows)
    margins = np.asarray(rollout.margins)[:25, 0, : len(task.grounding.atoms)]
    met = settled_by_schedule(task, (55, 40), margins)
    assert met == {}
    (index, step), *others = settled_by_chance(task, (55, 40), margins, met).items()
    assert index == 0 and not others
    column = task.grounding.atoms.index("A1")
    assert margins[step, column] == margins[:, column].max() >= 0


def test_a_visit_that_came_too_early_for_the_next_is_made_again(disk_cache):
    """A2 must follow A1 within 20 steps; the jump comes between the two."""
    task = build_task(load_task("linear-demo"), "F_[0:60](A1 & F_[0:20](A2)) & F_[0:60](A1)")
    schedule = (18, 12, 18)
    past = jump(task, schedule, 25, FAR)
    assert without(task, past, schedule) < 0
    found = replan(task, SEEKER, past, schedule)
    assert found.plan.satisfied
    assert found.plan.schedule[0] > 25 and found.plan.schedule[2] == 18


def test_times_are_given_up_with_those_that_they_are_tied_to(disk_cache):
    formula = "F_[0:60](A1 & F_[0:20](A2 & F_[0:9](B))) & F_[0:60](A1)"
    task = build_task(load_task("linear-demo"), formula)
    assert reopened(task, {0: 5, 1: 7, 3: 9}) == {3: 9}
    assert reopened(task, {0: 5, 1: 7, 2: 3}) == {0: 5, 1: 7, 2: 3}


def test_open_times_lie_ahead(task):
    left = left_open(task, {0: 20}, 30)
    assert left.low[:2].tolist() == [20, 30]
    assert left.high[:2].tolist() == [20, 60]


@pytest.mark.parametrize("mode", ["studio", "paper"])
def test_the_controller_is_led_along_the_past(task, mode):
    """After its own past it acts as if nothing had happened; its memory is that of the trace."""
    method = METHODS["tgpo-star"]
    algorithm = replace(method.preset(mode, task.robot), hidden=(16,))
    learner = method.learner(task, algorithm)
    controller = learner.controller(learner.weights(learner.fresh(3)))
    states, actions = trace(task, (20, 40), controller)
    rows = np.asarray(pad_schedule(task.problem, jnp.array([20, 40])))[None]
    spoilt = np.array(states[:, None])
    spoilt[24:] = 9.0  # nothing after the last known step counts
    rollout = roll_on(task, controller, spoilt, np.array([23]), rows)
    np.testing.assert_allclose(np.asarray(rollout.states)[:, 0], states, atol=1e-4)
    np.testing.assert_allclose(np.asarray(rollout.actions)[:, 0], actions, atol=1e-4)


def test_a_controller_without_schedules_goes_on_as_it_is(task):
    controller = Reactive(jnp.ones(()))
    states, actions = trace(task, (0, 0), controller)
    found = replan(task, controller, Past(states[:11], actions[:10]), (0, 0))
    np.testing.assert_allclose(found.plan.states, states, atol=1e-5)
    assert found.tried == 1


@pytest.mark.parametrize(
    "steps, actions, says",
    [
        (81, 80, "the past ends at step 80; an episode of 80 steps can be planned anew at steps 0"),
        (11, 9, "9 actions for 10 steps; expected one a step"),
    ],
)
def test_a_past_that_is_none_is_refused(task, steps, actions, says):
    past = Past(np.zeros((steps, 2), np.float32), np.zeros((actions, 2), np.float32))
    with pytest.raises(UserError, match=says):
        replan(task, SEEKER, past, (20, 40))
    with pytest.raises(UserError, match="the schedule has 1 values; the formula needs 2"):
        replan(task, SEEKER, Past(np.zeros((3, 2)), np.zeros((2, 2))), (20,))
    with pytest.raises(UserError, match=r"shape \(11, 3\); expected \[steps, 2\] for linear"):
        replan(task, SEEKER, Past(np.zeros((11, 3)), np.zeros((10, 2))), (20, 40))


def test_nudges_begin_where_the_past_ends(task):
    past = jump(task, (20, 50), 5)
    found = replan(task, Squinting(jnp.ones(())), past, (20, 50))
    assert found.plan.satisfied and found.plan.nudged
    assert not found.plan.nudges[:5].any()
    np.testing.assert_array_equal(found.plan.states[:6], past.states)
