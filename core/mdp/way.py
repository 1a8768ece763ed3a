"""Which way the current subgoal lies: around the obstacles, or as the crow flies.

Dimensions: d position, G subgoals, K points further along the way.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import jax.numpy as jnp

from core.mdp.episode import Checks
from core.task.problem import Problem, data_at
from core.task.protocols import Array
from core.task.windows import Windows, field_index


class Way(NamedTuple):
    """From a position to a subgoal."""

    distance: Array  # [] [m]
    direction: Array  # [d] unit direction of travel
    ahead: Array  # [K, d] unit directions of travel further along the way


def geodesic_way(  # noqa: PLR0913
    problem: Problem,
    windows: Windows,
    tau: Array,
    position: Array,
    rank: Array,
    doors: Array,
    steps: Sequence[float],
) -> Way:
    """The shortest way around the obstacles, by the distance field of the subgoal.

    Args:
        problem: the grounded task.
        windows: of the schedule.
        tau: current step.
        position: of the robot [d].
        rank: of the subgoal, in order of start.
        doors: combination of closed doors.
        steps: distances in robot lengths, rising, at which the way's direction is looked up.
    """
    subgoal = windows.order[jnp.minimum(rank, windows.order.shape[0] - 1)]
    index = field_index(problem.formula, subgoal, doors)
    way = partial(problem.world.field, _data_due(problem, windows, rank, tau), index)
    distance, direction = way(position)
    lengths = problem.robot.length * jnp.diff(jnp.asarray(steps), prepend=0.0)
    point, following, ahead = position, direction, []
    for length in lengths:
        point = point + length * following
        _, following = way(point)
        ahead.append(following)
    directions = jnp.stack(ahead) if ahead else jnp.zeros((0, *position.shape))
    return Way(distance, direction, directions)


def straight_way(checks: Checks, rank: Array, steps: Sequence[float]) -> Way:
    """The way up the gradient of the subgoal's margin, blind to obstacles; arguments as above."""
    last = jnp.minimum(rank, checks.subgoal.shape[0] - 1)
    direction = checks.gradient[last]  # the subgoals' gradients come first, in the same order
    ahead = jnp.broadcast_to(direction, (len(steps), *direction.shape))
    return Way(jnp.maximum(-checks.subgoal[last], 0.0), direction, ahead)


def _data_due(problem: Problem, windows: Windows, rank: Array, tau: Array) -> Any:
    """The world's data when the subgoal of a rank opens, or at the next step if that is later."""
    if problem.sites is None:
        return problem.data
    start = windows.start[jnp.minimum(rank, windows.order.shape[0] - 1)]
    return data_at(problem, jnp.maximum(start, tau + 1))
