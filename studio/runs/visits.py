"""How many visits a formula's repeated visits are planned with: for all chains together.

The least number that can work leaves no choice of times: G_[0:60](F_[0:60](A)) is A at step 60, and
together with G_[0:60](F_[0:60](B)) it is both at step 60. So each chain gets one visit more until
schedules leave time to travel.
"""

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.compilation import program
from core.errors import UserError
from core.task.problem import Problem, initial_states
from core.task.protocols import Array
from core.task.schedules import Search, forward_schedules, shortfall
from core.task.task import Task

ENOUGH = 0.25
"""Share of drawn schedules that leave time to travel from which no more visits are tried."""

MOST_EXTRA = 4
"""Most visits beyond the least number."""

STATES, DRAWN = 4, 16
"""Initial states, and schedules drawn for each."""


def with_enough_visits(build: Callable[[int], Task]) -> Task:
    """The task with the fewest visits that leave time to travel, or else the most time.

    Args:
        build: makes the task with a number of visits beyond the least.

    Raises:
        UserError: as `build` with none beyond the least.
    """
    best = task = build(0)
    if not task.grounding.decomposition.visits_missing:
        return task
    room = most = room_for(task.problem)
    for extra in range(1, MOST_EXTRA + 1):
        if room.share >= ENOUGH or not task.grounding.decomposition.visits_missing:
            break
        try:
            task = build(extra)
        except UserError:  # too large: the arrays hold no further visits
            break
        room = room_for(task.problem)
        if room > most:
            best, most = task, room
    return best


class Room(NamedTuple):
    """How much time schedules leave; the more the greater."""

    share: float
    """Of the schedules that leave time to travel."""
    slack: float
    """Minus the steps by which the best of them is too short, 0 if it is not."""


def room_for(problem: Problem) -> Room:
    """The room for schedules that are drawn forward in time."""
    share, least = _drawn(problem)
    return Room(float(share), -float(least))


@program
def _drawn(problem: Problem) -> tuple[Array, Array]:
    """Share of schedules that leave time to travel, and the least shortfall."""
    state_key, draw_key = jax.random.split(jax.random.key(0))
    states = jnp.repeat(initial_states(problem, state_key, count=STATES), DRAWN, axis=0)
    search = Search()
    schedules = forward_schedules(problem, search, draw_key, states)
    positions = jax.vmap(problem.robot.position)(states)
    short = jax.vmap(partial(shortfall, problem, reserve=search.reserve))(positions, schedules)
    return (short <= 0).mean(), short.min()
