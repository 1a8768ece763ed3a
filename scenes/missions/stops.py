"""Start, keys and goals of a mission, placed on a floor."""

from dataclasses import dataclass

import numpy as np

from core.errors import UserError
from scenes.missions.floor import VARIED, Area, Floor
from scenes.missions.outlines import circle, rectangle
from scenes.regions import Region

POINTS = 0.15
"""Share of varied missions that start at a point."""


@dataclass(frozen=True)
class Stops:
    """Where a mission leads.

    Attributes:
        start: The initial set.
        keys: One for each of the floor's doors.
        goals: Goals; the first ones lie in the floor's areas for goals.
        others: Alternatives to goals, for branches.
    """

    start: Region
    keys: tuple[Region, ...]
    goals: tuple[Region, ...]
    others: tuple[Region, ...]


def place_stops(floor: Floor, goals: int, others: int) -> Stops:
    """Random stops on a floor, apart from obstacles and from each other.

    Raises:
        UserError: no place was found for the start, a key, or the goals that must be there.
    """
    start = _start(floor)
    placed = [start]
    keys, wanted, more = [], [], []
    for number, door in enumerate(floor.doors, 1):
        key = _goal(floor, f"K{number}", placed, door.keys, outside=True)
        keys.append(key)
        placed.append(key)
    for number in range(max(goals, len(floor.goal_areas)) + others):
        given = number < len(floor.goal_areas)
        area = floor.goal_areas[number] if given else None
        try:
            goal = _goal(floor, f"A{number + 1}", placed, area)
        except UserError:
            if given or not wanted:
                raise
            break
        (wanted if number < max(goals, len(floor.goal_areas)) else more).append(goal)
        placed.append(goal)
    return Stops(start, tuple(keys), tuple(wanted), tuple(more))


def _start(floor: Floor) -> Region:
    half = floor.random.uniform(0.3, 0.7, 2) * floor.unit
    if floor.start_area is not None:
        half = np.minimum(half, 0.8 * floor.largest)
    if floor.varied and floor.chance(POINTS):
        outline = Region("initial", "point", (0.0, 0.0))
    elif floor.chance(0.3):
        outline = circle("initial", (0.0, 0.0), float(half[0]))
    else:
        outline = rectangle("initial", (-half[0], half[0]), (-half[1], half[1]))
    area = floor.start_area or floor.everywhere
    return floor.place(outline, area, floor.spread, [*floor.solid, *_closed(floor)])


def _goal(
    floor: Floor, name: str, placed: list[Region], area: Area | None, outside: bool = False
) -> Region:
    """A goal in an area, or anywhere: large enough for the robot to stop in."""
    clearance = floor.measures.clearance
    least, most = 0.4 * floor.unit, 0.75 * floor.unit
    radius = floor.between(max(least, 2 * clearance), max(most, 2.6 * clearance))
    if area is not None and not outside:
        radius = min(radius, floor.largest * floor.between(0.6, 1.0))
    if floor.chance(0.7):
        outline = circle(name, (0.0, 0.0), radius)
    else:
        outline = rectangle(name, (-0.9 * radius, 0.9 * radius), (-0.9 * radius, 0.9 * radius))
    anywhere = area is None or outside
    if floor.varied and (anywhere or radius > 3 * clearance) and floor.chance(VARIED):
        half = (1.2 if anywhere else 0.9) * radius
        outline = floor.shaped(rectangle(name, (-half, half), (-half, half)))
    others = floor.solid + (_closed(floor) if outside else [])
    spread = floor.spread
    return floor.place(outline, area or floor.everywhere, spread, [*others, *placed])


def _closed(floor: Floor) -> list[Region]:
    """The closed area as a region to stay out of."""
    if floor.closed is None:
        return []
    return [rectangle("closed", *zip(*floor.closed, strict=True))]
