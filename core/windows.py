"""Grounding of a schedule: when each task of the formula must hold.

For a schedule t the windows of the subgoals are sorted by their start (Sec. 4.2); tasks whose
guards t does not meet, and empty windows, never open. A schedule's *shortfall* is the number of
steps by which its legs are too short to travel: 0 for a schedule that is worth sampling.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.grounding import COMBINATIONS, NEVER, TaskArrays
from core.problem import Problem, closed_doors
from core.protocols import Array, Robot, World

UNREACHABLE = 100.0
"""Shortfall of an impossible order or an inadmissible chain [steps]."""

APART = 0.3
"""Distance from which two regions count as not meeting, in units of the robot's length."""


class Windows(NamedTuple):
    """Windows of one schedule, in steps; subgoals sorted by start."""

    schedule: Array  # [V]
    order: Array  # [G] index of the k-th subgoal in the formula's arrays
    start: Array  # [G]
    end: Array  # [G]
    count: Array  # [] number of subgoals that open
    constraint_start: Array  # [C]
    constraint_end: Array  # [C]
    last: Array  # [] step at which everything is decided


def task_windows(tasks: TaskArrays, schedule: Array) -> tuple[Array, Array]:
    """First and last step of each task [K]; NEVER for tasks that do not open."""
    t = schedule.astype(jnp.float32)
    start = tasks.start_weight @ t + tasks.start_offset
    end = tasks.end_weight @ t + tasks.end_offset
    agrees = ((tasks.guard < 0) | (tasks.guard == schedule)).all(-1)
    opens = (tasks.mask > 0) & agrees & (start <= end)
    return jnp.where(opens, start, NEVER), jnp.where(opens, end, NEVER)


def windows_of(problem: Problem, schedule: Array) -> Windows:
    """Windows of a schedule [V] of integers."""
    formula = problem.formula
    start, end = task_windows(formula.subgoals, schedule)
    order = jnp.argsort(start)
    constraint_start, constraint_end = task_windows(formula.constraints, schedule)
    ends = jnp.concatenate([end, constraint_end])
    last = jnp.where(ends < NEVER, ends, 0.0).max()
    return Windows(
        schedule.astype(jnp.float32),
        order,
        start[order],
        end[order],
        (start < NEVER).sum(),
        constraint_start,
        constraint_end,
        jnp.minimum(last, formula.horizon),
    )


def leg_slack(
    robot: Robot, world: World, problem: Problem, windows: Windows, position: Array, reserve: float
) -> tuple[Array, Array]:
    """Reserve of each leg [G] in steps, negative where it is too short, and the shortfall [].

    The k-th leg goes from the previous subgoal's region (from `position` [d] for the first) to
    the k-th, around the obstacles and doors that are closed when it begins; it needs
    `reserve` * distance / speed + lag steps. Where the previous window is still open when the
    next one starts, the regions must meet.
    """
    legs = _legs(robot, world, problem, windows, position, reserve)
    slack = jnp.where(legs.live, legs.available - legs.needed, 0.0)
    short = jax.nn.relu(-slack).sum() + UNREACHABLE * legs.conflict.sum()
    requirements = problem.formula.requirements
    agrees = ((requirements.guard < 0) | (requirements.guard == windows.schedule)).all(-1)
    lacking = jax.nn.relu(requirements.minimum - requirements.weight @ windows.schedule)
    return slack, short + UNREACHABLE * (lacking * agrees).sum()


class ShortLeg(NamedTuple):
    """The leg of a schedule that lacks most time; [] each."""

    source: Array  # index of the subgoal that it leaves, -1 for the initial position
    target: Array  # index of the subgoal that it goes to
    needed: Array  # steps with the reserve
    available: Array  # steps
    conflict: Array  # whether both subgoals are wanted at once though they do not meet


def shortest_leg(
    robot: Robot, world: World, problem: Problem, windows: Windows, position: Array, reserve: float
) -> ShortLeg:
    """The leg that decides whether a schedule leaves time to travel; see `leg_slack`."""
    legs = _legs(robot, world, problem, windows, position, reserve)
    lacking = legs.needed - legs.available + UNREACHABLE * legs.conflict
    worst = jnp.where(legs.live, lacking, -jnp.inf).argmax()
    source = jnp.where(worst > 0, windows.order[jnp.maximum(worst - 1, 0)], -1)
    return ShortLeg(
        source,
        windows.order[worst],
        legs.needed[worst],
        legs.available[worst],
        legs.conflict[worst],
    )


class _Legs(NamedTuple):
    """The legs of a schedule, in order of start."""

    live: Array  # [G] whether there is such a leg
    needed: Array  # [G] steps with the reserve
    available: Array  # [G] steps
    conflict: Array  # [G] whether both ends are wanted at once though they do not meet


def _legs(
    robot: Robot, world: World, problem: Problem, windows: Windows, position: Array, reserve: float
) -> _Legs:
    previous = jnp.concatenate([windows.order[:1], windows.order[:-1]])
    previous_start = jnp.concatenate([jnp.zeros(1), windows.start[:-1]])
    previous_end = jnp.concatenate([jnp.zeros(1), windows.end[:-1]])
    overlap = (previous_end >= windows.start).at[0].set(False)
    depart = jnp.where(overlap, previous_start, previous_end)
    doors = jax.vmap(closed_doors, (None, None, None, 0))(
        problem, windows.constraint_start, windows.constraint_end, depart
    )
    distance = problem.legs[doors, previous, windows.order]
    first, _ = world.field(problem.world, field_index(windows.order[0], doors[0]), position)
    distance = distance.at[0].set(first)
    live = jnp.arange(windows.start.shape[0]) < windows.count
    needed = jnp.where(distance > 0, reserve * distance / robot.speed + robot.lag, 0.0)
    conflict = live & overlap & (distance > APART * robot.length)
    return _Legs(live, needed, windows.start - depart, conflict)


def field_index(subgoal: Array, doors: Array) -> Array:
    """Index of the distance field of a subgoal under a combination of closed doors."""
    return subgoal * COMBINATIONS + doors
