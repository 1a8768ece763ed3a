"""Schedules drawn forward in time: many where uniform ones are few, all where all are good."""

from functools import partial

import jax
import numpy as np
import pytest

from core.task.problem import Problem, initial_states
from core.task.schedules import (
    Search,
    feasible_schedules,
    shortfall,
    uniform_schedules,
)
from scenes import load_task
from studio.runs.tasks import build_task

COUNT = 512
SEARCH = Search()


def _drawn(problem: Problem) -> dict[str, tuple[np.ndarray, float]]:
    """Schedules [N, V] by each way of drawing, and the share that leaves time."""
    drawn = _draw(problem, jax.random.key(7))
    return {name: (np.asarray(drawn[name][0]), float(drawn[name][1])) for name in drawn}


@jax.jit
def _draw(problem: Problem, key: jax.Array) -> dict[str, tuple[jax.Array, jax.Array]]:
    state_key, *keys = jax.random.split(key, 4)
    states = initial_states(problem, state_key, count=COUNT)
    positions = jax.vmap(problem.robot.position)(states)
    short = jax.vmap(partial(shortfall, problem, reserve=SEARCH.reserve))
    drawn = {
        "uniform": uniform_schedules(problem.formula, keys[0], COUNT),
        "feasible": feasible_schedules(problem, SEARCH, keys[1], states),
        "forward": feasible_schedules(problem, SEARCH, keys[2], states, forward=COUNT),
    }
    return {name: (found, (short(positions, found) <= 0).mean()) for name, found in drawn.items()}


@pytest.mark.parametrize("name, least", [("linear-05", 0.9), ("linear-10", 0.4)])
def test_tight_missions_have_many_forward_schedules(disk_cache, name, least):
    problem = build_task(load_task(name)).problem
    drawn = _drawn(problem)
    assert drawn["uniform"][1] < 0.06
    low, high = np.asarray(problem.formula.low), np.asarray(problem.formula.high)
    for schedules, share in (drawn["forward"], drawn["feasible"]):
        assert share > least
        assert (schedules >= low).all() and (schedules <= high).all()
        assert len(np.unique(schedules, axis=0)) > 0.9 * COUNT


PATROLS = "G_[0:60](F_[0:60](A1)) & G_[0:60](F_[0:60](A2))"


def test_visits_of_several_chains_are_found(disk_cache):
    """The last visit of each chain must not be too early, and each leg needs time."""
    problem = build_task(load_task("linear-07"), PATROLS).problem
    drawn = _drawn(problem)
    assert drawn["uniform"][1] < 0.05
    assert drawn["feasible"][1] > 0.5


def test_an_easy_domain_is_covered(disk_cache):
    problem = build_task(load_task("linear-06")).problem  # F_[10:90](A)
    drawn = _drawn(problem)
    times = {name: np.sort(schedules[:, 0]) for name, (schedules, _) in drawn.items()}
    assert drawn["forward"][1] == 1.0
    distance = np.abs(times["forward"] - times["feasible"]).max()
    assert distance < 10, "quantiles differ by more than chance"
    assert len(np.unique(times["forward"])) > 50


def test_a_search_that_does_not_prune_draws_uniformly(disk_cache):
    problem = build_task(load_task("linear-05")).problem
    key = jax.random.key(0)
    states = initial_states(problem, key, count=8)
    drawn = feasible_schedules(problem, Search(prune=False), key, states)
    np.testing.assert_array_equal(drawn, uniform_schedules(problem.formula, key, 8))
