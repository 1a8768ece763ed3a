"""A problem in the middle of an episode: what is left of it, and what has already failed.

Dimensions: L steps, V variables, E extended margins, K tasks, n state.
"""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp

from core.task.grounding import TaskArrays
from core.task.problem import Problem, extended_margins
from core.task.protocols import Array
from core.task.windows import task_windows


def later(problem: Problem, step: Array | int) -> Problem:
    """What is left of a problem at a step, as if an episode began there.

    Schedules keep their meaning. Windows that are over are left out, and what has begun is due at
    once; whether it was met is not asked. Regions that move have come as far as they have then.
    """
    formula = problem.formula
    formula = formula._replace(
        subgoals=_shifted(formula.subgoals, step), constraints=_shifted(formula.constraints, step)
    )
    if problem.sites is not None:
        sites = problem.sites._replace(since=problem.sites.since + step)
        return replace(problem, formula=formula, sites=sites)
    return replace(problem, formula=formula)


def past_margins(problem: Problem, states: Array) -> Array:
    """mu_ext [L + 1, E] in states [L + 1, n] of the steps from 0 on, in [m]."""
    if problem.sites is not None:
        steps = jnp.arange(states.shape[0], dtype=jnp.float32)
        at_step = jax.vmap(lambda state, step: extended_margins(problem, state, step)[0])
        return at_step(states, steps)
    return jax.vmap(lambda state: extended_margins(problem, state)[0])(states)


def failures(problem: Problem, mu: Array, step: Array, schedule: Array) -> Array:
    """How many tasks of a schedule [V] have failed by a step [].

    Args:
        problem: the whole problem.
        mu: extended margins [L + 1, E] of a trace, of which steps 0 to `step` count.
        step: the last step that counts.
        schedule: [V].
    """
    failed = partial(_failed, mu, step, schedule)
    return failed(problem.formula.subgoals).sum() + failed(problem.formula.constraints).sum()


def _failed(mu: Array, step: Array, schedule: Array, tasks: TaskArrays) -> Array:
    """Whether each task [K] has failed."""
    start, end = task_windows(tasks, schedule)
    number = jnp.arange(mu.shape[0])[:, None]
    inside = (start <= number) & (number <= end) & (number <= step)
    holds = tasks.sign * mu[:, tasks.predicate] >= 0  # false for NaN
    return (inside & ~holds).any(0)


def _shifted(tasks: TaskArrays, step: Array | int) -> TaskArrays:
    return tasks._replace(
        start_offset=tasks.start_offset - step, end_offset=tasks.end_offset - step
    )
