"""Unknown steps with bounds on their differences.

The bounds are kept closed: D[a, b] is the least w for which T_b - T_a <= w follows from all
bounds (shortest paths, Dechter, Meiri and Pearl 1991). All lower bounds together are a solution.

Dimensions: N unknown steps, the 0th of which is step 0.
"""

from typing import NamedTuple

import numpy as np

from core.task.feasibility.obligations import Instant, Obligations

UNBOUNDED = 10**9


class Constraint(NamedTuple):
    """T_b - T_a <= most."""

    a: int
    b: int
    most: int


def apart(first: Instant, second: Instant, steps: int) -> Constraint:
    """The second instant comes at least so many steps after the first."""
    return Constraint(second.node, first.node, second.offset - first.offset - steps)


class Bounds:
    """What is known of the steps; immutable."""

    def __init__(self, most: np.ndarray):
        self._most = most

    @classmethod
    def of(cls, obligations: Obligations) -> "Bounds":
        """What the intervals of the formula say alone."""
        size = len(obligations.nodes) + 1
        most = np.full((size, size), UNBOUNDED)
        np.fill_diagonal(most, 0)
        bounds = cls(most)
        for i, node in enumerate(obligations.nodes, start=1):
            parent, offset = node.after
            bounds = bounds.having(Constraint(parent, i, node.high + offset))
            bounds = bounds.having(Constraint(i, parent, -node.low - offset))
        return bounds

    def allows(self, constraint: Constraint) -> bool:
        """Whether the bounds with the constraint have a solution."""
        a, b, most = constraint
        return self._most[b, a] + most >= 0

    def implies(self, constraint: Constraint) -> bool:
        """Whether all solutions satisfy the constraint."""
        a, b, most = constraint
        return self._most[a, b] <= most

    def having(self, constraint: Constraint) -> "Bounds":
        """With a constraint that is allowed."""
        a, b, most = constraint
        known = self._most
        through = known[:, a, None] + most + known[None, b]
        return Bounds(np.minimum(known, through))

    def between(self, first: Instant, second: Instant) -> int:
        """Most steps from an instant to another one."""
        return int(second.offset - first.offset + self._most[first.node, second.node])

    def first(self, instant: Instant) -> int:
        """Least step of an instant."""
        return int(instant.offset - self._most[instant.node, 0])

    def last(self, instant: Instant) -> int:
        """Largest step of an instant."""
        return int(instant.offset + self._most[0, instant.node])
