"""How many visits a formula's repeated visits are planned with: for all chains together.

The least number that can work leaves no choice of times: G_[0:60](F_[0:60](A)) is A at step 60, and
together with G_[0:60](F_[0:60](B)) it is both at step 60. So each chain gets one visit more until
schedules leave time to travel. Where none does with any number, the task says so.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.compilation import program
from core.errors import UserError
from core.stl import to_text
from core.task.feasibility import Finding, Severity
from core.task.problem import Problem, initial_states
from core.task.protocols import Array
from core.task.schedules import Search, feasible_schedules, shortfall
from core.task.task import Task
from core.task.windows import TightLeg, tightest_leg, windows_of

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
        if (room.share, room.slack) > (most.share, most.slack):
            best, most = task, room
    return best if most.share > 0 else _hurried(best, most)


def _hurried(task: Task, room: "Room") -> Task:
    """The task with a warning that its visits leave too little time, and where they do."""
    names = [to_text(goal.predicate) for goal in task.grounding.subgoals]
    leg = room.tightest
    source = "the start" if int(leg.source) < 0 else names[int(leg.source)]
    words = (
        "at planning speed no schedule was found that leaves time for all repeated visits: the "
        f"best lacks {-room.slack:.0f} steps, most from {source} to {names[int(leg.target)]} "
        f"({float(leg.needed):.0f} are needed, {float(leg.available):.0f} are left)"
    )
    return replace(task, findings=(*task.findings, Finding(Severity.WARNING, words)))


class Room(NamedTuple):
    """How much time schedules leave."""

    share: float
    """Of the schedules that leave time to travel."""
    slack: float
    """Minus the steps by which the best of them is too short, 0 if it is not."""
    tightest: TightLeg
    """Of the best."""


def room_for(problem: Problem) -> Room:
    """The room for schedules that are drawn forward in time."""
    share, least, tightest = _drawn(problem)
    return Room(float(share), -float(least), tightest)


@program
def _drawn(problem: Problem) -> tuple[Array, Array, TightLeg]:
    """Share of schedules that leave time to travel; of the best, shortfall and tightest leg."""
    state_key, draw_key = jax.random.split(jax.random.key(0))
    states = jnp.repeat(initial_states(problem, state_key, count=STATES), DRAWN, axis=0)
    search = Search()
    schedules = feasible_schedules(problem, search, draw_key, states, forward=states.shape[0])
    positions = jax.vmap(problem.robot.position)(states)
    short = jax.vmap(partial(shortfall, problem, reserve=search.reserve))(positions, schedules)
    best = short.argmin()
    windows = windows_of(problem, schedules[best])
    tightest = tightest_leg(problem, windows, positions[best], search.reserve)
    return (short <= 0).mean(), short[best], tightest
