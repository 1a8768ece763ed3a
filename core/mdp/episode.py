"""The augmented state s = (x, tau, p_prev, p, r, chi) of Sec. 4.2, and quantities read from it.

Shared by both modes: which predicates hold now, which windows are violated, and the running
robustness of the grounded formula, min over tasks and over the steps of their windows. By the
decomposition theorem (docs/method.md) it is a lower bound of the formula's robustness, with
equality for the best schedule.
"""

from typing import NamedTuple

import jax.numpy as jnp

from core.task.grounding import TaskArrays
from core.task.problem import Problem, margins_between
from core.task.protocols import Array
from core.task.windows import Windows

SOUND = 1e6
"""Magnitude of a state's entries from which its simulation counts as diverged."""


class Episode(NamedTuple):
    """Augmented state of one episode."""

    state: Array  # [n] the robot's state x
    tau: Array  # [] time index [steps]
    previous_progress: Array  # [] p_prev
    progress: Array  # [] p, number of subgoals achieved
    certificate: Array  # [] r in {0, 1, 2}
    satisfied: Array  # [C] chi, 1 while a constraint was never violated
    alive: Array  # [] 1 while no task is violated
    robustness: Array  # [] running robustness of the grounded formula [m]; -inf if diverged


class Checks(NamedTuple):
    """Margins of all tasks at one instant, in windows' order, and which of them count."""

    subgoal: Array  # [G] margin of the k-th subgoal in order of start [m]
    constraint: Array  # [C] margin of the constraint's predicate, >= 0 where it holds [m]
    subgoal_open: Array  # [G] whether its window contains tau
    constraint_open: Array  # [C]
    gradient: Array  # [G + C, d] gradients of the margins
    between: Array | None  # [G + C] least margin since the step before, +inf where none counts [m]


def check(problem: Problem, windows: Windows, tau: Array, mu: Array, gradient: Array) -> Checks:
    """Evaluate every task's predicate at step tau from mu_ext [E] and its gradient [E, d]."""
    subgoal, subgoal_gradient = _signed(problem.formula.subgoals, mu, gradient)
    constraint, constraint_gradient = _signed(problem.formula.constraints, mu, gradient)
    return Checks(
        subgoal[windows.order],
        constraint,
        (windows.start <= tau) & (tau <= windows.end),
        (windows.constraint_start <= tau) & (tau <= windows.constraint_end),
        jnp.concatenate([subgoal_gradient[windows.order], constraint_gradient]),
        None
        if problem.between is None
        else jnp.full(windows.order.size + constraint.size, jnp.inf),
    )


def check_between(
    problem: Problem, windows: Windows, tau: Array, checks: Checks, states: tuple[Array, Array]
) -> Checks:
    """The checks at step tau, and what lies between the states [n] of the step before and of it.

    Tasks count whose windows contain both steps. Nothing changes where the problem looks at
    steps alone.
    """
    if problem.between is None:
        return checks
    mu, formula = margins_between(problem, *states, tau), problem.formula
    subgoal = (formula.subgoals.sign * mu[:, formula.subgoals.predicate]).min(0)[windows.order]
    constraint = (formula.constraints.sign * mu[:, formula.constraints.predicate]).min(0)
    start = jnp.concatenate([windows.start, windows.constraint_start])
    end = jnp.concatenate([windows.end, windows.constraint_end])
    margin = jnp.concatenate([subgoal, constraint])
    return checks._replace(
        between=jnp.where((start < tau) & (tau <= end), margin, jnp.inf),
    )


def _signed(tasks: TaskArrays, mu: Array, gradient: Array) -> tuple[Array, Array]:
    sign = jnp.asarray(tasks.sign)
    return sign * mu[tasks.predicate], sign[:, None] * gradient[tasks.predicate]


def before_start(state: Array, constraints: int) -> Episode:
    """Episode one step before it starts: observing its initial state makes it start.

    Args:
        state: initial state [n].
        constraints: C.
    """
    nothing = jnp.zeros((), jnp.int32)
    return Episode(
        state,
        jnp.float32(-1),
        nothing,
        nothing,
        nothing,
        jnp.ones(constraints),
        jnp.ones(()),
        jnp.float32(jnp.inf),
    )


def worst_open(checks: Checks) -> Array:
    """Smallest margin of the tasks whose windows contain this step, +inf if there is none."""
    subgoal = jnp.where(checks.subgoal_open, checks.subgoal, jnp.inf).min()
    worst = jnp.minimum(subgoal, worst_open_constraint(checks))
    return worst if checks.between is None else jnp.minimum(worst, checks.between.min())


def worst_open_constraint(checks: Checks) -> Array:
    """Smallest margin of the invariant constraints whose windows contain this step."""
    worst = jnp.where(checks.constraint_open, checks.constraint, jnp.inf).min()
    if checks.between is None:
        return worst
    return jnp.minimum(worst, checks.between[checks.subgoal.size :].min())


def violated_constraints(checks: Checks) -> Array:
    """Which of the invariant constraints [C] are violated at this step, or on the way to it."""
    violated = checks.constraint_open & (checks.constraint < 0)
    if checks.between is None:
        return violated
    return violated | (checks.between[checks.subgoal.size :] < 0)


def is_sound(state: Array) -> Array:
    """Whether a state [n] is finite and has not diverged; otherwise its episode fails."""
    return (jnp.abs(state) < SOUND).all()  # false for NaN
