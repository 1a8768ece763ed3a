"""Predicates of the state: linear inequalities over a robot's named quantities q.

    w q + c <= b        |w q + c| <= b        or the same with >=

Their margin is b less the left side (for >=, the left side less b), over the norm of w in scaled
units (see `quantities.scales_of`): what is missing to a bound on one quantity alone, in its own
units times its scale. Where only the position counts it is a signed distance, as that of a region.
The gradient along the position is exact, and zero for quantities that the position does not
decide.

Dimensions: K inequalities (padded), Q quantities, A atoms, d position, n state.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from core.task.protocols import Array, Robot
from core.task.quantities import axes_of, named_state, quantities_of, scales_of

MOST = 8
"""K, the inequalities of a scene."""


@dataclass(frozen=True)
class Inequality:
    """One inequality.

    Attributes:
        weights: w, by the names of quantities; not all zero.
        offset: c.
        absolute: Whether the left side is an absolute value.
        at_most: Whether it is <=, else >=.
        bound: b.
    """

    weights: Mapping[str, float]
    offset: float
    absolute: bool
    at_most: bool
    bound: float


class Inequalities(NamedTuple):
    """Inequalities as data."""

    atom: Array  # [K] index of the atom; beyond all atoms for padding
    weight: Array  # [K, Q] w
    offset: Array  # [K] c
    absolute: Array  # [K] 1 where the left side is an absolute value
    gain: Array  # [K] what turns a difference into a margin, negative for >=
    bound: Array  # [K] b
    axes: Array  # [Q, d] derivatives of the quantities along the position


def inequality_arrays(
    found: Sequence[Inequality], robot: Robot, first: int, beyond: int
) -> Inequalities:
    """At most `MOST` inequalities, padded.

    Args:
        found: their atoms come one after the other.
        robot: whose quantities are meant.
        first: index of the first one's atom.
        beyond: an index that no atom has.
    """
    names = [each.name for each in quantities_of(robot)]
    weight = np.zeros((MOST, len(names)), np.float32)
    offset, absolute, gain, bound = np.zeros((4, MOST), np.float32)
    atom = np.full(MOST, beyond, np.int32)
    for row, each in enumerate(found):
        atom[row] = first + row
        for name, value in each.weights.items():
            weight[row, names.index(name)] = value
        offset[row], absolute[row], bound[row] = each.offset, each.absolute, each.bound
        gain[row] = (1 if each.at_most else -1) / np.linalg.norm(weight[row] / scales_of(robot))
    arrays = (atom, weight, offset, absolute, gain, bound, axes_of(robot))
    return Inequalities(*map(jnp.asarray, arrays))


def inequality_margins(found: Inequalities, robot: Robot, state: Array) -> tuple[Array, Array]:
    """Margins [K] in a state [n], and their gradients [K, d] along the position."""
    quantity = named_state(robot, state)
    left = (found.weight * quantity).sum(-1) + found.offset
    side = jnp.where((found.absolute > 0) & (left < 0), -1.0, 1.0)
    margin = found.gain * (found.bound - side * left)
    return margin, -(found.gain * side)[:, None] * (found.weight @ found.axes)


def with_inequalities(
    found: Inequalities, robot: Robot, state: Array, known: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Margins [A] and gradients [A, d] of all atoms, given those of the regions."""
    margin, gradient = inequality_margins(found, robot, state)
    known_margin, known_gradient = known
    return (
        known_margin.at[found.atom].set(margin, mode="drop"),
        known_gradient.at[found.atom].set(gradient, mode="drop"),
    )


def scaled_quantities(found: Inequalities, robot: Robot, state: Array) -> Array:
    """Quantities [Q] that inequalities speak of, scaled, the others 0, in a state [n] [m].

    No margin changes by more than this point moves.
    """
    used = (found.weight != 0).any(0)
    return jnp.where(used, named_state(robot, state) * scales_of(robot), 0.0)
