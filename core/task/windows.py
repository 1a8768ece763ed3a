"""Grounding of a schedule: when each task of the formula must hold.

For a schedule t the windows of the subgoals are sorted by their start (Sec. 4.2); tasks whose
guards t does not meet, and empty windows, never open. A schedule's *shortfall* is the number of
steps by which its legs are too short to travel: 0 for a feasible schedule.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from core.task.grounding import NEVER, FormulaArrays, TaskArrays
from core.task.problem import Problem, closed_doors, data_at
from core.task.protocols import Array
from core.task.sites import Sites, center_at, depth_at

UNREACHABLE = 100.0
"""Shortfall of an impossible order, of an inadmissible chain or of a forbidden visit [steps]."""

RESERVE = 1.2
"""Planned duration of a leg over the shortest possible one."""

APART = 0.3
"""Distance from which two regions count as disjoint, in robot lengths."""


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
    """First and last step of each task [K]; NEVER for tasks that do not open.

    In the middle of an episode (`core.task.later`) bounds can be negative: a window that is over
    does not open any more, one that has begun opens at once.
    """
    t = schedule.astype(jnp.float32)
    start = _affine(tasks.start_weight, t) + tasks.start_offset
    end = _affine(tasks.end_weight, t) + tasks.end_offset
    agrees = ((tasks.guard < 0) | (tasks.guard == schedule)).all(-1)
    opens = (tasks.mask > 0) & agrees & (start <= end) & (end >= 0)
    start = jnp.maximum(start, 0)
    return jnp.where(opens, start, NEVER), jnp.where(opens, end, NEVER)


def _affine(weight: Any, schedule: Array) -> Array:
    """<weight, t> of each row [K], exact: an accelerator may round a matrix product's factors."""
    return (weight * schedule).sum(-1)


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


class Legs(NamedTuple):
    """The legs of a schedule, in order of start."""

    live: Array  # [G] whether there is such a leg
    needed: Array  # [G] steps with the reserve
    available: Array  # [G] steps
    overlap: Array  # [G] whether the previous window is still open when the target's opens
    conflict: Array  # [G] whether both ends must hold at once but are disjoint
    barred: Array  # [G] whether a constraint forbids the target while it is due


def legs_of(problem: Problem, windows: Windows, position: Array, reserve: float) -> Legs:
    """The legs of a schedule that starts at a position [d]; see `leg_slack`.

    Where regions move, a leg leads from where its source is when it begins to where its target is
    when its window opens.
    """
    robot = problem.robot
    previous = jnp.concatenate([windows.order[:1], windows.order[:-1]])
    previous_start = jnp.concatenate([jnp.zeros(1), windows.start[:-1]])
    previous_end = jnp.concatenate([jnp.zeros(1), windows.end[:-1]])
    overlap = (previous_end >= windows.start).at[0].set(False)
    depart = jnp.where(overlap, previous_start, previous_end)
    doors = jax.vmap(closed_doors, (None, None, None, 0))(
        problem, windows.constraint_start, windows.constraint_end, depart
    )
    distance = problem.legs[doors, previous, windows.order]
    meeting = None
    if problem.sites is not None:
        ways = partial(_moving_legs, problem, problem.sites, windows, previous, doors, distance)
        distance, meeting = ways(depart), ways(windows.start)
    goal = field_index(problem.formula, windows.order[0], doors[0])
    first, _ = problem.world.field(data_at(problem, windows.start[0]), goal, position)
    distance = distance.at[0].set(first)
    live = jnp.arange(windows.start.shape[0]) < windows.count
    needed = jnp.where(distance > 0, reserve * distance / robot.speed + robot.lag, 0.0)
    apart = distance if meeting is None else meeting
    conflict = live & overlap & (apart > APART * robot.length)
    bars = problem.formula.bars[windows.order] > 0
    meets = (windows.constraint_start <= windows.end[:, None]) & (
        windows.start[:, None] <= windows.constraint_end
    )
    barred = live & (bars & meets & (windows.constraint_start < NEVER)).any(-1)
    return Legs(live, needed, windows.start - depart, overlap, conflict, barred)


def _moving_legs(  # noqa: PLR0913
    problem: Problem,
    sites: Sites,
    windows: Windows,
    previous: Array,
    doors: Array,
    standing: Array,
    depart: Array,
) -> Array:
    """Distances [G] of the legs from sources, as they are at steps [G], to targets at their start.

    Args:
        problem: of which regions move.
        sites: its sites.
        windows: of a schedule.
        previous: the sources [G].
        doors: combinations of closed doors [G].
        standing: distances [G] where neither end moves [m].
        depart: steps [G].
    """

    def one(source: Array, target: Array, door: Array, leaves: Array, arrives: Array) -> Array:
        goal = field_index(problem.formula, target, door)
        center = center_at(sites, source, leaves)
        way, _ = problem.world.field(data_at(problem, arrives), goal, center)
        return jax.nn.relu(way - depth_at(sites, source, leaves))

    ways = jax.vmap(one)(previous, windows.order, doors, depart, windows.start)
    moves = sites.moves[previous] | sites.moves[windows.order]
    return jnp.where(moves, ways, standing)


def leg_slack(
    problem: Problem, windows: Windows, position: Array, reserve: float
) -> tuple[Array, Array]:
    """Slack of each leg [G] in steps, negative if it is too short, and the shortfall [].

    The k-th leg goes from the previous subgoal's region (from `position` [d] for the first) to
    the k-th, around the obstacles and doors that are closed when it begins; it needs
    `reserve` * distance / speed + lag steps. Where the previous window is still open when the
    next one starts, the regions must meet. What is visited must not be forbidden at that time.
    """
    legs = legs_of(problem, windows, position, reserve)
    return _slack(legs), shortfall_of(problem.formula, windows, legs)


def shortfall_of(formula: FormulaArrays, windows: Windows, legs: Legs) -> Array:
    """The shortfall [] of a schedule with these windows and legs; see `leg_slack`."""
    forbidden = legs.conflict.sum() + legs.barred.sum()
    lacking = lacking_of(formula, windows.schedule).sum()
    return jax.nn.relu(-_slack(legs)).sum() + UNREACHABLE * (forbidden + lacking)


def _slack(legs: Legs) -> Array:
    return jnp.where(legs.live, legs.available - legs.needed, 0.0)


def lacking_of(formula: FormulaArrays, schedule: Array) -> Array:
    """Steps [Q] by which a schedule [V] falls short of each requirement, 0 where it is met."""
    requirements, t = formula.requirements, schedule.astype(jnp.float32)
    agrees = ((requirements.guard < 0) | (requirements.guard == t)).all(-1)
    return agrees * jax.nn.relu(requirements.minimum - _affine(requirements.weight, t))


class TightLeg(NamedTuple):
    """The leg of a schedule with the least time to spare; [] each."""

    source: Array  # index of the subgoal that it leaves, -1 for the initial position
    target: Array  # index of the subgoal that it goes to
    needed: Array  # steps with the reserve
    available: Array  # steps
    conflict: Array  # whether both subgoals must hold at once but are disjoint
    barred: Array  # whether a constraint forbids the target while it is due


def tightest_leg(problem: Problem, windows: Windows, position: Array, reserve: float) -> TightLeg:
    """The leg with the least time to spare, which decides a schedule; see `leg_slack`."""
    legs = legs_of(problem, windows, position, reserve)
    lacking = legs.needed - legs.available + UNREACHABLE * (1.0 * legs.conflict + legs.barred)
    worst = jnp.where(legs.live, lacking, -jnp.inf).argmax()
    source = jnp.where(worst > 0, windows.order[jnp.maximum(worst - 1, 0)], -1)
    return TightLeg(
        source,
        windows.order[worst],
        legs.needed[worst],
        legs.available[worst],
        legs.conflict[worst],
        legs.barred[worst],
    )


def field_index(formula: FormulaArrays, subgoal: Array, doors: Array) -> Array:
    """Index of the distance field of a subgoal's place under a combination of closed doors."""
    return jnp.asarray(formula.place)[subgoal] * formula.combinations + doors
