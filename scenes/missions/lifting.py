"""From a floor plan to the regions of a scene, in the plane or in space.

In space walls and doors stand from floor to ceiling, other obstacles are pillars, blocks that
stand or hang, or float; goals float where the robot can reach them.
"""

from dataclasses import dataclass, replace

import numpy as np

from core.errors import UserError
from envs import make_robot
from scenes.layouts import half_extents
from scenes.missions.floor import Floor, Piece
from scenes.missions.reach import reaches
from scenes.missions.stops import Stops
from scenes.regions import SHAPES, Region

JOINED = 0.2
"""Share of varied missions in which two obstacles are one region."""

HEIGHTS = 20
"""Heights tried for a goal."""

COLORS = {
    "goal": "#8ecae6",
    "key": "#80c99b",
    "door": "#f4978e",
    "obstacle": "#7d8288",
    "wall": "#5f6368",
    "zone": "#cdb4db",
    "start": "#f6bd60",
}


@dataclass(frozen=True)
class Regions:
    """The regions of a mission, by what they are for."""

    start: Region
    keys: tuple[Region, ...]
    goals: tuple[Region, ...]
    others: tuple[Region, ...]
    doors: tuple[Region, ...]
    obstacles: tuple[Region, ...]
    walls: tuple[Region, ...]
    zone: Region | None

    @property
    def all(self) -> tuple[Region, ...]:
        """All but the start, in drawing order."""
        zone = () if self.zone is None else (self.zone,)
        return (
            *zone,
            *self.goals,
            *self.others,
            *self.keys,
            *self.doors,
            *self.obstacles,
            *self.walls,
        )


def regions_of(floor: Floor, stops: Stops) -> Regions:
    """The regions in the robot's space.

    Raises:
        UserError: the robot reaches no height of a goal.
    """
    lift = _Lift(floor)
    return Regions(
        start=_colored(lift.start(stops.start), "start"),
        keys=tuple(_colored(lift.goal(region), "key") for region in stops.keys),
        goals=tuple(_colored(lift.goal(region), "goal") for region in stops.goals),
        others=tuple(_colored(lift.goal(region), "goal") for region in stops.others),
        doors=tuple(_colored(lift.wall(door.region), "door") for door in floor.doors),
        obstacles=tuple(_colored(each, "obstacle") for each in lift.obstacles()),
        walls=tuple(_colored(wall, "wall") for wall in lift.borders()),
        zone=None if floor.zone is None else _colored(lift.zone(floor.zone), "zone"),
    )


class _Lift:
    """Raises the regions of a floor; in the plane it leaves them as they are."""

    def __init__(self, floor: Floor):
        self.floor, self.measures, self.random = floor, floor.measures, floor.random
        self.plane = self.measures.dimension == 2
        self.anywhere = make_robot(self.measures.robot).workspace.reach is None
        if self.plane:
            return
        bottom, top = self.measures.low[2], self.measures.high[2]
        inset = self.random.uniform(0.03, 0.08, 2) * (top - bottom)
        self.bottom, self.top = bottom + float(inset[0]), top - float(inset[1])

    def borders(self) -> list[Region]:
        """Walls around the free space, which reach beyond the arena."""
        floor, measures = self.floor, self.measures
        if self.plane and not floor.bordered:
            return []
        inner_low, inner_high = list(floor.low), list(floor.high)
        if not self.plane:
            inner_low.append(self.bottom)
            inner_high.append(self.top)
        low, high = np.array(measures.low), np.array(measures.high)
        beyond = 0.1 * (high - low)
        low, high = low - beyond, high + beyond
        axes = range(measures.dimension) if floor.bordered else (2,)
        walls = []
        for axis in axes:
            for below in (True, False):
                lows, highs = low.copy(), high.copy()
                (highs if below else lows)[axis] = (inner_low if below else inner_high)[axis]
                name = f"W{len(walls) + 1}"
                walls.append(_solid(name, lows, highs))
        return walls

    def wall(self, region: Region) -> Region:
        """From floor to ceiling."""
        if self.plane:
            return region
        beyond = 0.02 * (self.top - self.bottom)
        return _raised(region, self.bottom - beyond, self.top + beyond)

    def zone(self, region: Region) -> Region:
        """The whole height, nearly."""
        if self.plane:
            return region
        return _raised(region, self.bottom, self.top)

    def obstacles(self) -> list[Region]:
        """All obstacles; in a varied mission two are sometimes one region, like a wall's halves."""
        found = [self.obstacle(piece) for piece in self.floor.obstacles]
        simple = [region for region in found if region.kind in SHAPES]
        if self.floor.varied and len(simple) > 1 and self.random.random() < JOINED:
            first, second = simple[:2]
            joined = Region(first.name, "union", parts=(first, second))
            found[found.index(first)] = joined
            found.remove(second)
        return found

    def obstacle(self, piece: Piece) -> Region:
        """A wall, a pillar, a block that stands or hangs, or one that floats."""
        if self.plane or piece.tall:
            return self.wall(piece.region)
        region, random = piece.region, self.random
        height = self.top - self.bottom
        radius = float(half_extents(region).max())
        kind = random.choice(["tall", "standing", "hanging", "floating"], p=[0.4, 0.3, 0.1, 0.2])
        if kind == "floating" and region.kind == "circle" and 2.2 * radius < height:
            center = random.uniform(self.bottom + radius, self.top - radius)
            return Region(region.name, "sphere", (*region.center, float(center)), (radius,))
        way = 2 * self.measures.tight + 0.3 * self.measures.unit
        long = float(random.uniform(0.3, 1.0)) * (height - way)
        if kind == "tall" or long <= 0:
            return self.wall(region)
        if kind == "standing":
            return _raised(region, self.bottom - 0.02 * height, self.bottom + long)
        if kind == "hanging":
            return _raised(region, self.top - long, self.top + 0.02 * height)
        bottom = float(random.uniform(self.bottom, self.top - long))
        return _raised(region, bottom, bottom + long)

    def goal(self, region: Region) -> Region:
        """A sphere, or a region as high as it is wide, at a height that the robot reaches."""
        return self._floating(region, 1.0)

    def start(self, region: Region) -> Region:
        """A flat region at a height that the robot reaches."""
        return self._floating(region, 0.6)

    def _floating(self, region: Region, flatness: float) -> Region:
        half = half_extents(region)
        radius = float(half.min())
        for _ in range(HEIGHTS):
            raised = region
            if not self.plane:
                room = radius + self.measures.clearance
                if self.bottom + room >= self.top - room:
                    break
                z = float(self.random.uniform(self.bottom + room, self.top - room))
                raised = _raised(region, z - flatness * radius, z + flatness * radius)
                if region.kind == "circle" and self.random.random() < 0.6:
                    raised = Region(region.name, "sphere", raised.center, (radius,))
            if self.measures.arena is not None and self.anywhere:
                return raised
            if reaches(self.measures.robot, raised):
                return raised
        raise UserError(f"the robot reaches no height of {region.name}")


def _raised(region: Region, bottom: float, top: float) -> Region:
    """A region of the plane between two heights."""
    center = (*region.center, (bottom + top) / 2)
    match region.kind:
        case "point":
            return Region(region.name, "point", center)
        case "polygon":
            return Region(region.name, "prism", points=region.points, z=(bottom, top))
        case "union":
            parts = tuple(_raised(part, bottom, top) for part in region.parts)
            return Region(region.name, "union", parts=parts)
    kind = "cylinder" if region.kind == "circle" else "box"
    size = (*region.size, (top - bottom) / 2)
    return Region(region.name, kind, center, size, angle=region.angle)


def _solid(name: str, low: np.ndarray, high: np.ndarray) -> Region:
    """A box between two corners, a rectangle in the plane."""
    kind = "rectangle" if low.size == 2 else "box"
    center, size = (low + high) / 2, (high - low) / 2
    return Region(name, kind, tuple(center.tolist()), tuple(size.tolist()))


def _colored(region: Region, purpose: str) -> Region:
    """A region in its colour, in whole millimetres: a file shows what is meant."""
    return replace(_rounded(region), color=COLORS[purpose])


def _rounded(region: Region) -> Region:
    match region.kind:
        case "polygon" | "prism":
            points = tuple((round(x, 3), round(y, 3)) for x, y in region.points)
            z = tuple(round(value, 3) for value in region.z)
            return replace(region, center=(), size=(), points=points, z=z)
        case "union":
            return replace(region, center=(), size=(), parts=tuple(map(_rounded, region.parts)))
        case "point":
            return replace(region, center=tuple(round(value, 3) for value in region.center))
    return replace(
        region,
        center=tuple(round(value, 3) for value in region.center),
        size=tuple(round(value, 3) for value in region.size),
    )
