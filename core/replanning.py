"""Planning anew in the middle of an episode: after a push, or wherever a robot finds itself.

The trace up to step k is fixed. What it has met stays met, and stays that have begun go on; the
other times are chosen anew, at k or later. The controller is led along the past, so that its
memory is that of the trace, and acts from step k on. A continuation is judged by the exact
robustness of the whole trace, past included.

Dimensions: k last step of the past, L steps, K candidates, N schedules, V variables, n state,
A atoms.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.answer import THOROUGH, Effort, Plan, answer_jobs, best_answer
from core.ascent import Climb
from core.attempts import tries
from core.candidates import BLOCK, Ranking, ranked
from core.compilation import program, shape_of
from core.controller import Controller
from core.errors import UserError
from core.monitor import falsified_at
from core.rollout import Rollout, roll_on, roll_on_jobs
from core.settled import Settled, left_open, reopened, settled_by_chance, settled_by_schedule
from core.task.later import failures, later, past_margins
from core.task.problem import Problem, trace_margins
from core.task.protocols import Array
from core.task.task import Task


class Past(NamedTuple):
    """What has happened so far; the robot stands in the last state."""

    states: np.ndarray  # [k + 1, n]
    actions: np.ndarray  # [k, m]


@dataclass(frozen=True, eq=False)
class Replanned:
    """How an episode goes on."""

    plan: Plan
    """The whole trace, past included, and the schedule in force from now on."""
    step: int
    """k."""
    falsified: int | None
    """The step by which the past has made the formula false, whatever follows; else None."""
    tried: int
    """Attempts that were carried out."""
    seconds: float
    """Wall-clock time, compilation apart if it had been done before."""


def replan(
    task: Task,
    controller: Controller,
    past: Past,
    schedule: Sequence[int] | np.ndarray,
    *,
    seed: int = 0,
    effort: Effort = THOROUGH,
) -> Replanned:
    """The most robust continuation that a bounded search finds.

    Where none is found the nearest miss is returned, as by `answer`. Only `falsified` proves that
    there is none.

    Args:
        task: the grounded task.
        controller: carries out schedules; one that knows none goes on as it is.
        past: the trace so far.
        schedule: the one in force until now [V], padding included or not.
        seed: of the draws.
        effort: of the search.

    Raises:
        UserError: a past that is longer than the episode, or not one of this robot, or a schedule
            of too few times.
    """
    began, step = time.perf_counter(), _last_step(task, past)
    times = _own_times(task, schedule)
    trace = _lengthened(past.states, task.padded_horizon + 1)
    seen = _seen(task.problem, jnp.asarray(trace, jnp.float32))
    here = jnp.asarray(trace[step])
    names = task.grounding.atoms
    margins = np.asarray(seen.margins)[: step + 1, : len(names)]
    falsified = falsified_at(task.formula, margins, names)
    domains = [left_open(task, each, step) for each in _settled(task, times, margins)]

    def rank(number: int) -> Ranking:
        key = jax.random.fold_in(jax.random.key(seed), number)
        problem = replace(task.problem, formula=domains[number % len(domains)])
        drawn = ranked(later(problem, step), controller, key, here)
        return _unspoilt(task, seen, step, _with_first(drawn, times))

    def carry_out(schedules: np.ndarray, nudges: np.ndarray) -> Rollout:
        count = len(schedules)
        repeated = np.repeat(trace[:, None], count, 1)
        return roll_on(task, controller, repeated, np.full(count, step), schedules, nudges)

    if falsified is not None or controller.search is None:
        effort = effort._replace(rounds=1)
    climb = Climb(task, controller, trace, known=step)
    found = best_answer(task, rank, carry_out, climb, seed=seed, effort=effort)
    actions = np.concatenate([past.actions, found.plan.actions[step:]])
    nudges = np.concatenate([np.zeros_like(found.plan.nudges[:step]), found.plan.nudges[step:]])
    plan = replace(found.plan, actions=actions, nudges=nudges)
    spent = time.perf_counter() - began - found.compile_seconds
    return Replanned(plan, step, falsified, found.tried, spent)


def replan_jobs(task: Task, controller: Controller) -> list[Callable[[], Any]]:
    """Compilations that `replan` needs."""
    states = shape_of(task.padded_horizon + 1, task.robot.state_size, dtype=jnp.float32)
    mu = _seen.shapes(task.problem, states).extended
    variables = task.problem.formula.low.shape
    step, schedules = shape_of(dtype=jnp.int32), shape_of(BLOCK, *variables, dtype=jnp.int32)
    return [
        *answer_jobs(task, controller),
        *roll_on_jobs(task, controller, tries(task)),
        partial(_seen.compile, task.problem, states),
        partial(_failures.compile, task.problem, mu, step, schedules),
    ]


class _Seen(NamedTuple):
    """A trace that counts to step k, lengthened to the episode's end."""

    states: Array  # [L + 1, n]
    margins: Array  # [L + 1, A]
    extended: Array  # [L + 1, A + P]


@program
def _seen(problem: Problem, states: Array) -> _Seen:
    return _Seen(
        states, trace_margins(problem, states[:, None])[:, 0], past_margins(problem, states)
    )


@program
def _failures(problem: Problem, mu: Array, step: Array, schedules: Array) -> Array:
    """Tasks of each of the schedules [N, V] that have failed by step k: [N]."""
    return jax.vmap(partial(failures, problem, mu, step))(schedules)


def _settled(task: Task, schedule: tuple[int, ...], margins: np.ndarray) -> list[Settled]:
    """What the rounds of a search settle, in turn.

    First what the schedule has met; then less, where an open time is tied to a settled one; then
    what was met by chance too.
    """
    met = settled_by_schedule(task, schedule, margins)
    turns: list[Settled] = []
    for each in (met, reopened(task, met), settled_by_chance(task, schedule, margins, met)):
        if each not in turns:
            turns.append(each)
    return turns


def _with_first(drawn: Ranking, schedule: tuple[int, ...]) -> Ranking:
    """The candidates [N, V], the last one replaced by the schedule in force, which comes first."""
    row = np.zeros_like(np.asarray(drawn.schedules)[:1])
    row[0, : len(schedule)] = schedule
    orders = np.asarray(drawn.orders)
    own_kind = np.full((1, orders.shape[1]), -1, orders.dtype)
    schedules = np.concatenate([row, np.asarray(drawn.schedules)[:-1]])
    return Ranking(schedules, np.concatenate([own_kind, orders[:-1]]))


def _unspoilt(task: Task, seen: _Seen, step: int, drawn: Ranking) -> Ranking:
    """The candidates of which the past has made the fewest tasks fail, best or none."""
    schedules, last = jnp.asarray(drawn.schedules), jnp.asarray(step, jnp.int32)
    failed = np.asarray(_failures(task.problem, seen.extended, last, schedules))
    kept = np.flatnonzero(failed == failed.min())
    return Ranking(drawn.schedules[kept], drawn.orders[kept])


def _lengthened(states: np.ndarray, length: int) -> np.ndarray:
    """States [k + 1, n] as [L + 1, n], the last one repeated."""
    last = np.repeat(states[-1:], length - len(states), 0)
    return np.concatenate([states, last]).astype(np.float32)


def _own_times(task: Task, schedule: Sequence[int] | np.ndarray) -> tuple[int, ...]:
    """The values of the formula's own variables."""
    decomposition = task.grounding.decomposition
    count = len(decomposition.variables)
    if len(schedule) < count:
        raise UserError(f"the schedule has {len(schedule)} values; the formula needs {count}")
    return decomposition.own_values(schedule)


def _last_step(task: Task, past: Past) -> int:
    """k, after checking that the past is the beginning of an episode of this robot.

    Raises:
        UserError: it is not.
    """
    size, steps = task.robot.state_size, len(past.states) - 1
    if np.ndim(past.states) != 2 or past.states.shape[1] != size:  # noqa: PLR2004
        raise UserError(
            f"the past has states of shape {np.shape(past.states)}; expected [steps, {size}] "
            f"for {task.robot.name}"
        )
    if not 0 <= steps < task.horizon:
        raise UserError(
            f"the past ends at step {steps}; an episode of {task.horizon} steps can be planned "
            f"anew at steps 0 to {task.horizon - 1}"
        )
    if len(past.actions) != steps:
        raise UserError(
            f"the past has {len(past.actions)} actions for {steps} steps; expected one a step"
        )
    return steps
