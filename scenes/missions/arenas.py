"""Arenas of other sizes than a robot's own."""

import numpy as np

from envs import make_robot
from scenes.arena import Arena

SHARE = 0.35
"""Share of missions in an arena of their own."""

LARGEST_FACTOR = 2.0
"""Of an arena's sides, over the robot's; the smallest is the inverse."""

LONGEST = 0.4
"""Largest binary logarithm of a side over the geometric mean of it and the other one."""

LEAST_REACHED = 0.6
"""Shortest sides over the robot's, of an arena within its reach."""


def draw_arena(robot_name: str, random: np.random.Generator) -> Arena | None:
    """An arena for a mission; None for the robot's own.

    A robot that goes anywhere has arenas from half to twice as large, not all of them square. One
    that reaches no farther than its arena has a part of that.
    """
    if random.random() >= SHARE:
        return None
    workspace = make_robot(robot_name).workspace
    low, high = np.array(workspace.arena, float).T
    sides = high - low
    if workspace.reach is not None:
        length = random.uniform(LEAST_REACHED, 1.0, low.size) * sides
        begin = low + random.uniform(0.0, 1.0, low.size) * (sides - length)
        return _rounded(begin, begin + length, 3)
    factor = LARGEST_FACTOR ** random.uniform(-1.0, 1.0)
    ratio = 2.0 ** random.uniform(-LONGEST, LONGEST)
    length = factor * sides
    length[:2] *= [ratio, 1 / ratio]
    middle = (low + high) / 2 + random.uniform(-0.5, 0.5, low.size) * length
    begin = middle - length / 2
    begin[2:] = low[2:]  # the ground stays where it is
    return _rounded(begin, begin + length, 2)


def _rounded(low: np.ndarray, high: np.ndarray, digits: int) -> Arena:
    pairs = zip(low.round(digits).tolist(), high.round(digits).tolist(), strict=True)
    return tuple(pairs)
