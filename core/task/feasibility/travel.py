"""How many steps a robot needs from one place to another.

`Fastest` is a lower bound: no behaviour is faster. `Planned` is what plans count on.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from core.task.protocols import Robot, farthest_of

NEVER = 10**6
"""Steps of a way that no episode is long enough for."""

FURTHER = 500
"""Steps beyond the episode's that a way may take, for the words."""

_TINY = 1e-9  # of a step
_FAR = 1e6  # [m]; farther than any two regions


class Travel(Protocol):
    """A measure of ways."""

    def steps(self, gaps: np.ndarray, since: int) -> int:
        """Least steps that a way takes, at least one.

        Args:
            gaps: Distances [K, d + 1] along each axis and in all, of K ways [m].
            since: Latest step of the episode at which it can begin.
        """
        ...


@dataclass(frozen=True)
class Fastest:
    """No faster than the robot can be.

    Attributes:
        robot: One that begins its episodes at rest.
        horizon: Last step that the formula looks at.
        slack: Distance by which rounding may lengthen a step [m].
    """

    robot: Robot
    horizon: int
    slack: float

    def steps(self, gaps: np.ndarray, since: int) -> int:
        """See `Travel`."""
        begin = min(max(since, 0), self.horizon)
        ways = _ways(self.robot, 2 * self.horizon + FURTHER, self.slack)
        reached = ways[begin:] - ways[begin]
        enough = [int((reached < gap).any(1).sum()) for gap in gaps]
        least = min(enough, default=NEVER)
        return NEVER if least >= len(reached) else max(1, least)


@dataclass(frozen=True)
class Planned:
    """At the speed that legs are planned with, along straight lines."""

    robot: Robot

    def steps(self, gaps: np.ndarray, since: int) -> int:
        """See `Travel`."""
        del since
        distance = float(gaps[:, -1].min()) if len(gaps) else math.inf
        if distance == math.inf:
            return NEVER
        lag = self.robot.lag if distance > 0 else 0.0
        return max(1, math.ceil(distance / self.robot.speed + lag - _TINY))


@lru_cache(maxsize=32)
def _ways(robot: Robot, steps: int, slack: float) -> np.ndarray:
    """Most that is covered in the first so many steps, along each axis and in all [H + 1, d + 1].

    A kilometre and more for a step that nothing bounds.
    """
    each = np.array([farthest_of(robot, step) for step in range(steps)], float)
    each = np.minimum(each + slack, _FAR)
    return np.concatenate([np.zeros((1, each.shape[1])), np.cumsum(each, axis=0)])
