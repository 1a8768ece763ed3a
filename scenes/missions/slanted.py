"""Families of floors with walls and outlines that do not follow the axes."""

import numpy as np

from core.errors import UserError
from scenes.missions.floor import Floor, Piece, new_floor
from scenes.missions.measures import Measures
from scenes.missions.outlines import rectangle
from scenes.regions import Region


def slanted(measures: Measures, random: np.random.Generator) -> Floor:
    """A wall across the floor at an angle, with one or two gaps; sometimes only half of it."""
    floor = new_floor(measures, random)
    angle = round(float(np.sign(floor.between(-1, 1))) * floor.between(12.0, 60.0), 1)
    if floor.chance(0.5):
        angle += 90.0
    middle = np.array([floor.share(axis, floor.between(0.35, 0.65)) for axis in (0, 1)])
    along = np.array([np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))])
    half, tall = floor.thickness(), floor.chance(0.7)
    first, last = _crossing(floor, middle, along)
    beside = floor.passage + 0.4 * floor.unit + half
    if last - first < 2 * beside:
        raise UserError("the wall is too short for a gap")
    gap = floor.between(first + beside, last - beside)
    ends = [(first - 3 * half, gap - floor.passage), (gap + floor.passage, last + 3 * half)]
    if floor.chance(0.25):
        ends = [ends[int(floor.chance(0.5))]]
    for low, high in ends:
        name, center = f"O{len(floor.obstacles) + 1}", middle + (low + high) / 2 * along
        size = (high - low) / 2, half
        wall = Region(name, "rectangle", tuple(center.tolist()), size, angle=angle)
        floor.obstacles.append(Piece(wall, tall))
    floor.pillars(int(random.integers(0, 3)), 0.9)
    floor.detour = 1.4
    return floor


def hall(measures: Measures, random: np.random.Generator) -> Floor:
    """A room to remain in whose outline is a polygon: an L, a Z, or with corners cut off."""
    floor = new_floor(measures, random, bordered=False)
    inset = random.uniform(0.02, 0.1, (2, 2)) * (floor.high - floor.low)
    floor.low, floor.high = floor.low + inset[0], floor.high - inset[1]
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    missing = random.choice(4, int(random.integers(1, 3)), replace=False)
    middle, half = (floor.low + floor.high) / 2, (floor.high - floor.low) / 2
    outline: list[np.ndarray] = []
    for number, sign in enumerate(signs):
        corner = middle + sign * half
        if number not in missing:
            outline.append(corner)
            continue
        cut = sign * random.uniform(0.5, 0.95, 2) * half
        upright, level = corner - cut * [0, 1], corner - cut * [1, 0]
        before, after = (upright, level) if sign[0] == sign[1] else (level, upright)
        inner = [] if floor.chance(0.3) else [corner - cut]
        outline += [before, *inner, after]
        name = f"outside {number}"
        if inner:
            x, y = np.sort([corner, corner - cut], axis=0).T
            floor.outside.append(rectangle(name, x.tolist(), y.tolist()))
        else:
            floor.outside.append(_polygon(name, [before, corner, after]))
    floor.zone = _polygon("Z", outline)
    floor.polygons -= 1
    floor.pillars(int(random.integers(0, 4)), 0.8)
    floor.detour = 1.35
    return floor


def _crossing(floor: Floor, middle: np.ndarray, along: np.ndarray) -> tuple[float, float]:
    """Where a line leaves the free floor, in [m] along it from its middle."""
    with np.errstate(divide="ignore"):
        marks = np.sort([(floor.low - middle) / along, (floor.high - middle) / along], axis=0)
    return float(marks[0].max()), float(marks[1].min())


def _polygon(name: str, corners: list[np.ndarray]) -> Region:
    return Region(name, "polygon", points=tuple((float(x), float(y)) for x, y in corners))
