"""Ways stay in what must hold all the time: an L-shaped room is not left on the way to a goal."""

from dataclasses import replace

import numpy as np
import pytest

from scenes import Region, load_task
from studio.runs.tasks import build_task

L_ROOM = ((-4.5, -4.5), (4.5, -4.5), (4.5, -1.0), (-1.0, -1.0), (-1.0, 4.5), (-4.5, 4.5))
REGIONS = (
    Region("room", "polygon", points=L_ROOM),
    Region("A", "circle", (3.5, -2.5), (0.5,)),
    Region("B", "circle", (-2.5, 3.5), (0.5,)),
)
START = Region("initial", "point", (-3.5, -3.5))


def _way(formula: str) -> float:
    """Length of the way from A to B [m]."""
    scene = replace(load_task("linear-demo"), regions=REGIONS, initial=START, formula=formula)
    task = build_task(scene)
    goals = [str(subgoal.predicate) for subgoal in task.grounding.subgoals]
    legs = np.asarray(task.problem.legs)[0]
    one, other = (next(i for i, goal in enumerate(goals) if f"'{name}'" in goal) for name in "AB")
    return float(legs[one, other])


def test_a_room_that_may_not_be_left_bends_the_way():
    straight = np.hypot(6.0, 6.0) - 0.9  # from rim to 0.1 m inside
    assert _way("F_[0:60](A) & F_[0:60](B)") == pytest.approx(straight, rel=0.03)
    around = 2 * np.hypot(1.5, 4.5) - 0.9  # by the corner at (-1, -1), at least
    found = _way("G_[0:60](room) & F_[0:60](A) & F_[0:60](B)")
    assert 0.98 * around < found < 1.1 * around
    assert _way("G_[0:9](room) & F_[0:60](A) & F_[0:60](B)") == pytest.approx(straight, rel=0.03)
