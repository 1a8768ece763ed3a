"""Candidates: schedules that are drawn for states, and what a controller thinks of them.

Every caller draws and scores in blocks of one size, so that two small programs serve all answers,
choices and maps of a task: what is compiled is waited for.

Dimensions: B = `BLOCK` rows, N candidates, R states, K candidates for each, n state, V variables,
G subgoals.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import key_shape, program, shape_of
from core.controller import Controller
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.schedules import Search, feasible_schedules
from core.task.task import Task
from core.task.windows import windows_of

BLOCK = 512
"""Rows of a call of the compiled programs."""

SHARED = 8
"""A pool that states choose from has one schedule for so many candidates."""


class Ranking(NamedTuple):
    """Candidates, the one that scores highest first."""

    schedules: np.ndarray  # [N, V]
    orders: np.ndarray  # [N, G] subgoals in order of start, -1 for those that do not open


def ranked(problem: Problem, controller: Controller, key: Array, state: Array) -> Ranking:
    """`BLOCK` candidates from a state [n]; zeros for a controller that knows no schedules."""
    if controller.search is None:
        subgoals = problem.formula.subgoals.mask.shape[0]
        nothing = np.zeros((BLOCK, *problem.formula.low.shape), np.int32)
        return Ranking(nothing, np.zeros((BLOCK, subgoals), np.int32))
    states = jnp.broadcast_to(jnp.asarray(state, jnp.float32), (BLOCK, *state.shape))
    schedules, orders = _draw(problem, key, states, search=controller.search)
    best_first = np.argsort(-np.asarray(_score(problem, controller, states, schedules)))
    return Ranking(np.asarray(schedules)[best_first], np.asarray(orders)[best_first])


def choose_schedules(
    problem: Problem, controller: Controller, key: Array, states: Array
) -> tuple[Array, Array]:
    """The controller's choice for each state [R, n]: schedules [R, V] and their scores [R].

    Of K candidates for each state, the one that scores highest. Zeros for a controller that
    knows no schedules.
    """
    count, search = states.shape[0], controller.search
    if search is None:
        return jnp.zeros((count, *problem.formula.low.shape), jnp.int32), jnp.zeros(count)
    given = np.asarray(states, np.float32)
    least = count * max(1, search.candidates // SHARED)
    pool, _ = _pool(problem, search, key, given, least)
    deal = np.random.default_rng(np.asarray(jax.random.key_data(key)))
    dealt = pool[deal.integers(len(pool), size=(count, search.candidates))]
    flat = dealt.reshape(-1, *dealt.shape[2:])
    scores = _scores(problem, controller, np.repeat(given, search.candidates, 0), flat)
    scores = scores.reshape(count, -1)
    row, best = np.arange(count), scores.argmax(1)
    return jnp.asarray(dealt[row, best]), jnp.asarray(scores[row, best])


def scored_schedules(
    problem: Problem, controller: Controller, key: Array, states: Array
) -> tuple[Array, Array]:
    """A candidate for each state [R, n], whatever its score: schedules [R, V] and scores [R].

    Half of the states have candidates that are drawn forward in time.

    Raises:
        ValueError: a controller that knows no schedules.
    """
    if controller.search is None:
        raise ValueError("the controller knows no schedules that could be scored")
    given = np.asarray(states, np.float32)
    pool, rows = _pool(problem, controller.search, key, given, len(given))
    schedules = pool[np.unique(rows, return_index=True)[1]]
    return jnp.asarray(schedules), jnp.asarray(_scores(problem, controller, given, schedules))


def candidate_jobs(task: Task, controller: Controller) -> list[Callable[[], Any]]:
    """Compilations that candidates need."""
    if controller.search is None:
        return []
    states: Any = shape_of(BLOCK, task.robot.state_size, dtype=jnp.float32)
    schedules: Any = shape_of(BLOCK, *task.problem.formula.low.shape, dtype=jnp.int32)
    return [
        partial(_draw.compile, task.problem, key_shape(), states, search=controller.search),
        partial(_score.compile, task.problem, controller, states, schedules),
    ]


def _pool(
    problem: Problem, search: Search, key: Array, states: np.ndarray, least: int
) -> tuple[np.ndarray, np.ndarray]:
    """Schedules [N, V] for states [R, n], and for which of them each is [N], in rising order.

    N is a multiple of `BLOCK`, and `least` or more.
    """
    blocks = -(-least // BLOCK)
    rows = np.arange(blocks * BLOCK) * len(states) // (blocks * BLOCK)
    repeated = jnp.asarray(states[rows])
    keys = jax.random.split(key, blocks)
    parts = [
        _draw(problem, keys[i], repeated[i * BLOCK : (i + 1) * BLOCK], search=search)[0]
        for i in range(blocks)
    ]
    return np.concatenate([np.asarray(part) for part in parts]), rows


def _scores(
    problem: Problem, controller: Controller, states: np.ndarray, schedules: np.ndarray
) -> np.ndarray:
    """Scores [N] of schedules [N, V] from states [N, n]."""
    count = len(states)
    rows = np.arange(-(-count // BLOCK) * BLOCK) % count
    given, flat = jnp.asarray(states[rows]), jnp.asarray(schedules[rows])
    parts = [
        _score(problem, controller, given[i : i + BLOCK], flat[i : i + BLOCK])
        for i in range(0, len(rows), BLOCK)
    ]
    return np.concatenate([np.asarray(part) for part in parts])[:count]


@program
def _draw(problem: Problem, key: Array, states: Array, *, search: Search) -> tuple[Array, Array]:
    """A schedule for each state [B, n], and the order of its subgoals: [B, V] and [B, G].

    The latter half is drawn forward in time.
    """
    schedules = feasible_schedules(problem, search, key, states, forward=states.shape[0] // 2)

    def order(schedule: Array) -> Array:
        windows = windows_of(problem, schedule)
        return jnp.where(jnp.arange(windows.order.size) < windows.count, windows.order, -1)

    return schedules, jax.vmap(order)(schedules)


@program
def _score(problem: Problem, controller: Controller, states: Array, schedules: Array) -> Array:
    """Scores [B] of schedules [B, V] from states [B, n]."""
    return jax.vmap(partial(controller.score, problem))(states, schedules)
