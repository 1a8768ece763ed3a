"""The tasks that are closest to being violated, as a policy perceives them."""

import jax.numpy as jnp

from core.mdp.episode import Checks
from core.task.protocols import Array
from core.task.windows import Windows


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
