"""Families of floors: what stands where, by name.

Whole families are held out: nothing that is trained on is ever drawn from `HELD_OUT`.
"""

from types import MappingProxyType

import numpy as np

from scenes.missions.floor import Area, Door, Family, Floor, new_floor
from scenes.missions.measures import Measures
from scenes.missions.outlines import rectangle
from scenes.missions.slanted import hall, slanted

CROSSINGS_OF_TWO = 3
"""Ways across the arena that a mission with two doors needs time for."""


def open_floor(measures: Measures, random: np.random.Generator) -> Floor:
    """Up to five obstacles of any size; in the plane sometimes without walls around."""
    bordered = measures.dimension > 2 or random.random() < 0.8
    floor = new_floor(measures, random, bordered)
    floor.pillars(int(random.integers(0, 6)), 1.8)
    return floor


def gaps(measures: Measures, random: np.random.Generator) -> Floor:
    """A wall with one or two gaps, from barely passable to wide."""
    floor = new_floor(measures, random)
    axis = int(random.integers(2))
    first = floor.gap(axis)
    openings = [first]
    second = floor.gap(axis)
    if floor.chance(0.4) and abs(second - first) > 2 * floor.passage + floor.unit:
        openings.append(second)
    floor.wall(axis, floor.share(axis, floor.between(0.33, 0.67)), openings, tall=floor.chance(0.7))
    floor.pillars(int(random.integers(0, 3)), 0.9)
    floor.detour = 1.4
    return floor


def corridor(measures: Measures, random: np.random.Generator) -> Floor:
    """Two long walls with a lane between them; most of the mission lies in the lane."""
    floor = new_floor(measures, random)
    axis = int(random.integers(2))
    along = 1 - axis
    middle = floor.share(axis, floor.between(0.25, 0.75))
    length = floor.between(0.3, 0.5) * floor.span(along)
    center = floor.share(along, floor.between(0.4, 0.6))
    ends = center - length, center + length
    for sign in (-1, 1):
        inner = middle + sign * floor.passage
        outer = inner + sign * 2 * floor.thickness()
        across = (min(inner, outer), max(inner, outer))
        floor.block(*((across, ends) if axis == 0 else (ends, across)))
    lane = floor.side(axis, middle - 1e-3, middle + 1e-3)
    if floor.chance(0.7):
        floor.start_area = lane
    floor.goal_areas = [lane] * int(random.integers(1, 4))
    floor.largest = 0.9 * floor.passage
    floor.spread = min(floor.spread, 0.05 * floor.passage)
    floor.detour = 1.3
    return floor


def hanging(measures: Measures, random: np.random.Generator) -> Floor:
    """One or two walls that reach from one side into the floor."""
    floor = new_floor(measures, random)
    axis = int(random.integers(2))
    along = 1 - axis
    count = int(random.integers(1, 3))
    shares = [(0.4, 0.6)] if count == 1 else [(0.25, 0.4), (0.6, 0.75)]
    for low, high in shares:
        at, half = floor.share(axis, floor.between(low, high)), floor.thickness()
        free = max(2 * floor.passage, 0.2 * floor.span(along))
        free = floor.between(free, max(free, 0.6 * floor.span(along)))
        if floor.chance(0.5):
            ends = floor.low[along] - 0.1 * floor.unit, floor.high[along] - free
        else:
            ends = floor.low[along] + free, floor.high[along] + 0.1 * floor.unit
        across = at - half, at + half
        floor.block(*((across, ends) if axis == 0 else (ends, across)), tall=floor.chance(0.7))
    floor.pillars(int(random.integers(0, 3)), 0.9)
    floor.detour = 1.35
    return floor


def doors(measures: Measures, random: np.random.Generator) -> Floor:
    """One or two walls, each with a door; the key to each lies before it."""
    floor = new_floor(measures, random)
    axis = int(random.integers(2))
    single = floor.chance(0.4) or measures.crossings < CROSSINGS_OF_TWO
    shares = [(0.35, 0.65)] if single else [(0.28, 0.4), (0.62, 0.72)]
    walls = [floor.share(axis, floor.between(*share)) for share in shares]
    backwards = floor.chance(0.5)
    edge = floor.high[axis] if backwards else floor.low[axis]
    before = edge
    for at in walls[::-1] if backwards else walls:
        keys = floor.side(axis, *sorted((before, at)))
        floor.wall(axis, at, [floor.gap(axis)], keys=keys)
        if floor.start_area is None:
            floor.start_area = keys
        before = at if floor.chance(0.5) else edge
    if floor.chance(0.8):
        last = walls[0] if backwards else walls[-1]
        opposite = floor.low[axis] if backwards else floor.high[axis]
        floor.goal_areas = [floor.side(axis, *sorted((last, opposite)))]
    floor.detour = 1.4
    return floor


def pillars(measures: Measures, random: np.random.Generator) -> Floor:
    """Many small obstacles, as far apart as the passage is wide."""
    floor = new_floor(measures, random)
    floor.pillars(int(random.integers(4, 12)), 0.9)
    floor.detour = 1.25
    return floor


def box(measures: Measures, random: np.random.Generator) -> Floor:
    """A box to remain in instead of walls, or a zone to stay in while goals are visited."""
    whole = random.random() < 0.5
    floor = new_floor(measures, random, bordered=not whole)
    if whole:
        inset = random.uniform(0.03, 0.12, (2, 2)) * (floor.high - floor.low)
        floor.low, floor.high = floor.low + inset[0], floor.high - inset[1]
        floor.zone = rectangle("Z", *zip(floor.low, floor.high, strict=True))
    else:
        half = random.uniform(0.17, 0.3, 2) * (floor.high - floor.low)
        outline = rectangle("Z", (-half[0], half[0]), (-half[1], half[1]))
        floor.zone = floor.place(outline, floor.everywhere, 0.0, [])
        center = np.array(floor.zone.center)
        floor.goal_areas = [(center - 0.7 * half, center + 0.7 * half)] * int(random.integers(1, 3))
    floor.pillars(int(random.integers(0, 5)), 0.9 if whole else 0.6)
    return floor


def rooms(measures: Measures, random: np.random.Generator) -> Floor:
    """Four rooms: two crossing walls, a gap in each arm."""
    floor = new_floor(measures, random)
    for axis in (0, 1):
        at = floor.share(axis, floor.between(0.46, 0.54))
        floor.wall(axis, at, [floor.gap(axis, 0.0, 0.44), floor.gap(axis, 0.56, 1.0)])
    floor.detour = 1.5
    return floor


def s_bend(measures: Measures, random: np.random.Generator) -> Floor:
    """Two walls with gaps at opposite ends."""
    floor = new_floor(measures, random)
    axis = int(random.integers(2))
    shares = [(0.0, 0.4), (0.6, 1.0)]
    if floor.chance(0.5):
        shares = shares[::-1]
    for where, share in zip(((0.3, 0.38), (0.62, 0.7)), shares, strict=True):
        at = floor.share(axis, floor.between(*where))
        floor.wall(axis, at, [floor.gap(axis, *share)])
    floor.detour = 1.6
    return floor


def chamber(measures: Measures, random: np.random.Generator) -> Floor:
    """A closed room in a corner with a door; the key and the start lie outside."""
    floor = new_floor(measures, random)
    inner = random.uniform(0.3, 0.42, 2) * (floor.high - floor.low)
    corner = random.integers(2, size=2)
    sign = np.where(corner == 0, 1.0, -1.0)
    edge = np.where(corner == 0, floor.low, floor.high)
    far = edge + sign * inner
    half = floor.thickness()
    outer = far + sign * 2 * half
    beyond = edge - sign * 0.1 * floor.unit
    floor.block(_sorted(beyond[0], outer[0]), _sorted(far[1], outer[1]))
    passage = min(floor.passage, 0.4 * inner[1])
    gap = edge[1] + sign[1] * floor.between(passage, inner[1] - passage)
    across = _sorted(far[0], outer[0])
    low, high = _sorted(beyond[1], far[1])
    for ends in ((low, gap - passage), (gap + passage, high)):
        if ends[1] - ends[0] > 0.1 * floor.unit:
            floor.block(across, ends)
    door = rectangle("D1", across, (gap - passage, gap + passage))
    floor.doors.append(Door(door, floor.everywhere))
    floor.closed = _area(edge, outer)
    floor.goal_areas = [_area(edge, far)]
    floor.pillars(int(random.integers(0, 3)), 0.7)
    floor.detour = 1.4
    return floor


def _sorted(first: float, second: float) -> tuple[float, float]:
    return (first, second) if first <= second else (second, first)


def _area(first: np.ndarray, second: np.ndarray) -> Area:
    return np.minimum(first, second), np.maximum(first, second)


FAMILIES: MappingProxyType[str, Family] = MappingProxyType(
    {
        "open": open_floor,
        "gaps": gaps,
        "corridor": corridor,
        "hanging": hanging,
        "doors": doors,
        "pillars": pillars,
        "box": box,
        "slanted": slanted,
        "hall": hall,
        "rooms": rooms,
        "s-bend": s_bend,
        "chamber": chamber,
    }
)
"""All families by name."""

HELD_OUT = ("rooms", "s-bend", "chamber")
"""Families that no training ever sees."""

TRAINED = tuple(name for name in FAMILIES if name not in HELD_OUT)
"""Families that weights are trained on."""

SHIPPED_TRAINED = ("01", "02", "03", "04", "06", "07", "08")
"""Shipped tasks whose perturbed versions weights are trained on."""

SHIPPED_HELD_OUT = ("05", "09", "10", "demo")
"""Shipped tasks that no training of weights ever sees, nor any version of them."""
