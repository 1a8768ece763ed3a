"""Geodesic distance fields on a grid over the workspace.

d(p) is the shortest travel distance from p to a goal set around the blocked cells, the
viscosity solution of |grad d| * v = 1 with d = 0 on the goal, found by fast marching
(scikit-fmm). Blocked cells are slow (v = BLOCKED_SPEED), not walls, so that the field leads out
of an obstacle too.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import skfmm

BLOCKED_SPEED = 0.05
"""Speed inside a blocked cell relative to free space."""

REMEMBERED = 192
"""Fields that are kept, at most 40 MB: where a goal is dragged, only its own field is new."""


@dataclass(frozen=True)
class Grid:
    """Nodes `origin + spacing * index`, `shape` of them."""

    origin: tuple[float, ...]  # [d] [m]
    spacing: float  # [m]
    shape: tuple[int, ...]  # [d]

    @property
    def dimension(self) -> int:
        """Dimension d of the workspace."""
        return len(self.shape)

    def nodes(self) -> np.ndarray:
        """Positions of all nodes [prod(shape), d] in [m], last axis fastest."""
        ends = zip(self.origin, self.shape, strict=True)
        axes = [low + self.spacing * np.arange(count) for low, count in ends]
        return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, self.dimension)


def geodesic_field(
    grid: Grid, goal: np.ndarray, blocked: np.ndarray, inset: float = 0.1
) -> np.ndarray:
    """Distance and unit direction of travel [*shape, 1 + d] to a goal around blocked cells.

    Args:
        grid: the nodes.
        goal: margin of the goal's predicate at the nodes [*shape], in [m].
        blocked: whether a node is blocked [*shape].
        inset: aim at positions this far inside the goal, where it is deep enough [m].

    Returns:
        Read-only; the same array where the same was asked for shortly before.
    """
    return _field(grid, inset, goal.dtype.str, goal.tobytes(), np.asarray(blocked, bool).tobytes())


@lru_cache(maxsize=REMEMBERED)
def _field(grid: Grid, inset: float, kind: str, goal_bytes: bytes, blocked_bytes: bytes):
    """See `geodesic_field`; arrays as bytes, which can be looked up."""
    goal = np.frombuffer(goal_bytes, kind).reshape(grid.shape)
    blocked = np.frombuffer(blocked_bytes, bool).reshape(grid.shape)
    field = _marched(grid, goal, blocked, inset)
    field.flags.writeable = False
    return field


def _marched(grid: Grid, goal: np.ndarray, blocked: np.ndarray, inset: float) -> np.ndarray:
    level = min(inset, 0.5 * float(goal.max()))
    phi = level - goal
    if phi.min() >= 0:  # no node inside: aim at the best one
        phi = np.ones(grid.shape)
        phi[np.unravel_index(goal.argmax(), grid.shape)] = -1.0
    elif phi.max() <= 0:
        return np.zeros((*grid.shape, 1 + grid.dimension), np.float32)
    speed = np.where(blocked, BLOCKED_SPEED, 1.0)
    distance = np.asarray(skfmm.travel_time(phi, speed, dx=grid.spacing))
    distance = np.where(phi <= 0, 0.0, distance)
    slope = np.stack(list(np.gradient(distance, grid.spacing)), -1)
    slope = slope / (np.linalg.norm(slope, axis=-1, keepdims=True) + 1e-6)
    return np.concatenate([distance[..., None], -slope], -1).astype(np.float32)


def interpolate(grid: Grid, table: Any, index: Any, position: jax.Array) -> jax.Array:
    """Multilinear interpolation of one of many fields.

    Args:
        grid: the nodes.
        table: fields [F, *shape, c].
        index: which field, scalar.
        position: [d] in [m]; positions outside the grid are clipped to its border.

    Returns:
        Values [c].
    """
    shape = jnp.asarray(grid.shape)
    cell = (position - jnp.asarray(grid.origin)) / grid.spacing
    cell = jnp.clip(cell, 0.0, shape - 1.001)
    low = cell.astype(jnp.int32)
    fraction = cell - low
    start = (index, *low, 0)
    sizes = (1, *(2,) * grid.dimension, table.shape[-1])
    corner = jax.lax.dynamic_slice(table, start, sizes)[0]
    value = jnp.zeros(table.shape[-1])
    for offset in product((0, 1), repeat=grid.dimension):
        chosen = jnp.asarray(offset)
        weight = jnp.prod(jnp.where(chosen == 1, fraction, 1 - fraction))
        value = value + weight * corner[offset]
    return value
