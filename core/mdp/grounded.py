"""The MDP of one schedule: what the modes act on (Sec. 4.2)."""

from typing import Any, NamedTuple

from core.task.problem import Problem
from core.task.protocols import Array
from core.task.windows import Windows, leg_slack, windows_of


class GroundedMdp(NamedTuple):
    """A problem whose time variables have values, seen from one initial position."""

    problem: Problem
    windows: Windows
    slack: Array  # [G] reserve of each leg [steps]
    shortfall: Array  # [] steps by which legs are too short


AXES: Any = GroundedMdp(None, 0, 0, 0)  # pyright: ignore[reportArgumentType]
"""`in_axes` of `jax.vmap` for many schedules of one problem."""


def ground_schedule(
    problem: Problem, position: Array, schedule: Array, *, reserve: float
) -> GroundedMdp:
    """The MDP of a schedule [V] from a position [d]; `reserve` as in `leg_slack`."""
    windows = windows_of(problem, schedule)
    return GroundedMdp(problem, windows, *leg_slack(problem, windows, position, reserve))
