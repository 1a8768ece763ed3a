"""Climbs: what they reach, what they leave alone, and that the nudges which they return do it."""

from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core import ascent
from core.ascent import Climb, ascent_jobs
from core.attempts import Kind
from core.evaluation import rollout_robustness
from core.rollout import roll_on, roll_out
from scenes import load_task
from studio.runs.tasks import build_task, initial_state
from tests.core.test_answer import Squinting

COUNT = 3
SLOW = Squinting(jnp.full((), 0.5))
"""Goes to the goals' sides, and slowly."""


@pytest.fixture(scope="module")
def task(disk_cache):
    return build_task(load_task("linear-demo"), "F_[0:60](A1) & F_[0:60](A2)")


def climb_of(task, known=0):
    state = np.asarray(initial_state(task))
    return Climb(task, SLOW, np.repeat(state[None], task.padded_horizon + 1, 0), known)


def attempts(task, actions):
    schedule = np.zeros(task.problem.formula.low.shape, np.int32)
    schedule[:2] = 30, 55
    one: Any = SimpleNamespace(schedule=schedule, kind=Kind((0, 1)), actions=actions)
    return [one] * COUNT


@pytest.fixture(scope="module")
def missed(task):
    """A rollout that ends beside both goals."""
    states = jnp.repeat(initial_state(task)[None], COUNT, 0)
    schedules = np.stack([each.schedule for each in attempts(task, None)])
    rollout = roll_out(task, SLOW, states, jnp.asarray(schedules))
    assert rollout_robustness(task, rollout).max() < -0.1
    return np.asarray(rollout.actions)[:, 0]


@pytest.fixture(scope="module")
def climbed(task, missed):
    return climb_of(task)(attempts(task, missed))


def test_attempts_that_miss_come_to_satisfy_the_formula(task, climbed):
    assert len(climbed) == COUNT
    states = jnp.repeat(initial_state(task)[None], COUNT, 0)
    schedules = jnp.asarray(np.stack([each.schedule for each in climbed]))
    nudges = np.stack([each.nudges for each in climbed], 1)
    found = rollout_robustness(task, roll_out(task, SLOW, states, schedules, nudges))
    assert found.min() >= 0.09  # the target, but for rounding in a closed loop
    assert found.max() < 0.4  # and not much further


def test_the_schedule_and_its_kind_stay(climbed):
    assert {each.kind for each in climbed} == {Kind((0, 1))}
    assert climbed[0].schedule[:2].tolist() == [30, 55]


def test_what_is_out_of_reach_is_dropped(missed):
    far = build_task(load_task("linear-demo"), "F_[0:3](A2)", force=True)
    assert climb_of(far)(attempts(far, missed)) == []


def test_the_past_stays(task, missed):
    known = 12
    climb = climb_of(task, known)
    climb.states[1 : known + 1] += 0.1  # it has been pushed a little
    found = climb(attempts(task, missed))
    assert found and not found[0].nudges[:known].any()
    count = len(found)
    rollout = roll_on(
        task,
        SLOW,
        np.repeat(climb.states[:, None], count, 1),
        np.full(count, known),
        np.stack([each.schedule for each in found]),
        np.stack([each.nudges for each in found], 1),
    )
    np.testing.assert_array_equal(rollout.states[: known + 1, 0], climb.states[: known + 1])
    assert rollout_robustness(task, rollout).min() >= 0


def test_the_slope_is_that_of_the_margin(task, missed):
    past = jnp.asarray(climb_of(task).states[:, None])
    known, step, atom = jnp.zeros(1, jnp.int32), jnp.array([20]), jnp.array([1])
    actions = jnp.asarray(missed[:, None]) * 0.5
    slope = ascent._slope(task.problem, past, known, actions, step, atom)

    def margin(actions):
        return float(ascent._carried(task.problem, past, known, actions)[1][20, 0, 1])

    direction = jax.random.normal(jax.random.key(0), actions.shape)
    change = margin(actions + 0.01 * direction) - margin(actions - 0.01 * direction)
    assert change == pytest.approx(0.02 * float((slope * direction).sum()), rel=0.02)
    assert not np.asarray(slope)[20:].any()


def test_there_is_nothing_to_climb_in_true_physics():
    task = build_task(load_task("ant-demo"))
    assert ascent_jobs(task, SLOW, COUNT) == []
    assert Climb(task, SLOW, np.zeros((1, 1)), 0)([]) == []
