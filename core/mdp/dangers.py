"""The tasks that are closest to being violated, as a policy perceives them.

An action counts from the next step on. Where regions move, margins are foreseen as if the robot
stood: a stay's at the next step, an invariant's the least of this step and the next `FORESEEN`, so
that a robot that learnt among obstacles that stand gives way in time. No way leads around what
moves, as ways lead around obstacles that stand, at a distance; so what moves is perceived wider by
`CAUTION`.
"""

import jax
import jax.numpy as jnp

from core.mdp.episode import Checks, check
from core.task.problem import Problem, extended_margins
from core.task.protocols import Array
from core.task.windows import Windows

FORESEEN = 3
"""Steps for which the margins of invariants are foreseen."""

CAUTION = 0.2
"""By how much what moves is perceived as wider than it is, in robot lengths."""


def coming_checks(problem: Problem, windows: Windows, tau: Array, state: Array) -> Checks:
    """The checks of a state [n] at step tau as they are about to be if the robot stands."""

    def foreseen(step: Array) -> Checks:
        return check(problem, windows, tau, *extended_margins(problem, state, step))

    checks = jax.vmap(foreseen)(tau + jnp.arange(FORESEEN + 1))
    following = jax.tree.map(lambda leaf: leaf[1], checks)
    worst = checks.constraint.argmin(0)  # [C]
    row = jnp.arange(worst.size)
    subgoals = following.subgoal.size
    gradient = checks.gradient[worst, subgoals + row]
    moves = jnp.ptp(checks.constraint, axis=0) > 0
    caution = CAUTION * problem.robot.length * moves
    return following._replace(
        constraint=checks.constraint[worst, row] - caution,
        gradient=jnp.concatenate([following.gradient[:subgoals], gradient]),
    )


def nearest_dangers(
    windows: Windows, tau: Array, checks: Checks, length: float, count: int
) -> tuple[Array, Array]:
    """Margins [count] and directions [count, d] of the tasks closest to being violated.

    The closest first; directions fade with distance, and margins are in units of `length`.
    Candidates are the constraints that hold at the next step and the stays that are open.
    """
    soon = tau + 1
    constraint = (windows.constraint_start <= soon) & (soon <= windows.constraint_end)
    stay = (windows.start <= tau) & (soon <= windows.end)
    margin = jnp.where(
        jnp.concatenate([stay, constraint]),
        jnp.concatenate([checks.subgoal, checks.constraint]),
        9.0 * length,
    )
    values, directions = [], []
    for _ in range(count):  # faster than a sort
        nearest = margin.argmin()
        value = margin[nearest] / length
        values.append(value)
        directions.append(-checks.gradient[nearest] * jnp.exp(-3 * jnp.clip(value, -0.3, 3.0)))
        margin = margin.at[nearest].set(9.0 * length)
    return jnp.stack(values), jnp.stack(directions)
