"""Attempts: what differs between them, and that the best counts."""

from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.evaluation import evaluate, trace_robustness
from core.methods import METHODS
from core.rollout import roll_out, start_states
from tests.core.toy import PointRobot, toy_task


@pytest.fixture(scope="module")
def task():
    return toy_task("F_[0:12](A)")


def rolled(task, controller, states):
    schedules = jnp.zeros((len(states), *task.problem.formula.low.shape), jnp.int32)
    return np.asarray(roll_out(task, controller, states, schedules).actions)


def fresh(task, method):
    algorithm = replace(METHODS[method].preset("studio", PointRobot()), hidden=(8,))
    learner = METHODS[method].learner(task, algorithm)
    return learner.controller(learner.weights(learner.fresh(0)))


@pytest.mark.parametrize(("method", "count"), [("tau-mdp", 10), ("cem", 10), ("grad", 1)])
def test_how_many_there_are(task, method, count):
    controller = fresh(task, method)
    attempts = controller.attempts
    assert len(attempts) == count
    assert jax.tree.structure(attempts[0]) == jax.tree.structure(controller)
    states = start_states(task.problem, jax.random.key(1), count=3)
    actions = [rolled(task, attempt, states) for attempt in attempts]
    np.testing.assert_array_equal(actions[0], rolled(task, controller, states))
    for number, one in enumerate(actions):
        assert all(np.abs(one - other).max() > 0.01 for other in actions[:number])


def test_draws_are_independent_and_repeated_exactly(task):
    """Standard normal in units of sigma, apart for every start and step, equal when repeated."""
    controller: Any = fresh(task, "tau-mdp")
    attempt = controller.attempts[4]
    states = start_states(task.problem, jax.random.key(1), count=64)
    quiet, drawn = rolled(task, controller, states), rolled(task, attempt, states)
    np.testing.assert_array_equal(drawn, rolled(task, attempt, states))
    assert np.abs(quiet).max() < 0.1  # fresh policies hardly act, so what is left is the draw
    inside = np.abs(drawn) < 1
    sigma = float(np.exp(controller.weights.heads.log_std[0]))
    assert 0.6 < inside.mean() < 0.95
    assert np.median(np.abs(drawn)) == pytest.approx(0.674 * sigma, rel=0.1)
    flat = drawn.reshape(drawn.shape[0], -1)
    assert np.unique(np.round(drawn[inside], 6)).size > 0.95 * inside.sum()
    assert np.abs(np.corrcoef(flat.T)[~np.eye(flat.shape[1], dtype=bool)]).mean() < 0.35


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Drifting:
    """Moves steadily; its attempts move in other directions."""

    action: jax.Array

    search = None

    @property
    def attempts(self):
        return tuple(replace(self, action=self.action * sign) for sign in (1.0, -1.0))

    def score(self, problem, state, schedule):
        return jnp.zeros(())

    def start(self, problem, state, schedule):
        return jnp.zeros(())

    def step(self, problem, memory, state):
        return memory, self.action


def test_the_best_attempt_counts():
    """A is to the right: the first attempt of one, and the second of the other, reach it."""
    task = toy_task("F_[0:12](A)")
    right, left = Drifting(jnp.array([0.5, 0.0])), Drifting(jnp.array([-0.5, 0.0]))
    found = [evaluate(task, each, jax.random.key(0), count=8).robustness for each in (right, left)]
    np.testing.assert_array_equal(found[0], found[1])
    assert (found[0] >= 0).all()
    states = start_states(task.problem, jax.random.split(jax.random.key(0))[0], count=8)
    schedules = jnp.zeros((8, *task.problem.formula.low.shape), jnp.int32)
    alone = roll_out(task, left, states, schedules)
    assert (trace_robustness(task, np.asarray(alone.margins)) < 0).all()
