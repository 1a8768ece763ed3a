"""One iteration of the cross-entropy method against its formulas (App. A.3)."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.evaluation import trace_robustness
from core.methods.cross_entropy import (
    CrossEntropy,
    CrossEntropyLearner,
    _candidates,
    _select,
    _try,
    iteration_keys,
)
from core.methods.whole_formula.timed import TimedController
from core.rollout import roll_out
from core.task.problem import initial_states
from tests.core.toy import toy_task

SMALL = CrossEntropy(hidden=(4,), population=12, elite=3, starts=2, deviation=0.7)


@pytest.fixture(scope="module")
def begun():
    task = toy_task("F_[0:12](A)")
    state = CrossEntropyLearner(task, SMALL).fresh(0)
    return task, state.distribution, iteration_keys(state.key)


def test_the_elite_gives_mean_and_deviation(begun):
    _, distribution, keys = begun
    fitness = jnp.asarray(np.random.default_rng(0).normal(size=SMALL.population), jnp.float32)
    best = np.argsort(-np.asarray(fitness))[: SMALL.elite]
    found = _select(distribution, keys, fitness, algorithm=SMALL)
    drawn = jax.tree.map(np.asarray, _candidates(distribution, keys, SMALL))
    for leaf, mean, deviation in zip(
        *map(jax.tree.leaves, (drawn, found.mean, found.deviation)), strict=True
    ):
        elite = leaf[best]
        np.testing.assert_allclose(mean, elite.mean(0), rtol=1e-4, atol=1e-5)
        spread = np.sqrt(((elite - elite.mean(0)) ** 2).sum(0) / (SMALL.elite - 1))
        np.testing.assert_allclose(deviation, spread, rtol=1e-3, atol=1e-5)


def test_what_is_tried_is_what_is_averaged(begun):
    """Every candidate from the same states, and in their order."""
    task, distribution, keys = begun
    trials = _try(task.problem, distribution, keys, algorithm=SMALL, steps=task.padded_horizon)
    found = trace_robustness(task, np.asarray(trials.margins)).reshape(SMALL.population, -1)
    states = initial_states(task.problem, keys.states, count=SMALL.starts)
    schedules = jnp.zeros((SMALL.starts, *task.problem.formula.low.shape), jnp.int32)
    drawn = _candidates(distribution, keys, SMALL)
    for number in (0, 5, 11):
        actor = jax.tree.map(lambda leaf, n=number: leaf[n], drawn)
        rollout = roll_out(task, TimedController(SMALL.hidden, actor), states, schedules)
        expected = trace_robustness(task, np.asarray(rollout.margins))
        np.testing.assert_allclose(found[number], expected, atol=1e-4)
    assert np.ptp(found) > 0.1
