"""A floor plan: where regions of a mission are drawn, seen from above.

Robots that move in space take the first two axes as the floor; `scenes.missions.lifting` raises
the plan into space.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from core.errors import UserError
from scenes.layouts import half_extents
from scenes.missions.measures import Measures
from scenes.missions.outlines import circle, rectangle
from scenes.missions.placing import find_position
from scenes.missions.shapes import varied
from scenes.regions import Region
from scenes.shared import ROOM

PLACES = 60
"""Positions tried for a region."""

VARIED = 0.4
"""Share of obstacles and goals that are neither circles nor rectangles along the axes."""

SMALLEST_PIECE = 0.1
"""Pieces of walls shorter than this are left out, in units."""

Area = tuple[np.ndarray, np.ndarray]
"""Low and high corner [2] in [m]."""


@dataclass(frozen=True)
class Piece:
    """A region of the plan and whether it stands from floor to ceiling in space.

    Attributes:
        region: Its outline.
        tall: Whether it reaches from floor to ceiling for certain.
        free: Whether it stands apart from all others.
    """

    region: Region
    tall: bool
    free: bool = False


@dataclass(frozen=True)
class Door:
    """A closed passage and where the key to it may lie."""

    region: Region
    keys: Area


@dataclass
class Floor:
    """A plan while it is drawn.

    Attributes:
        measures: Of the robot.
        random: Draws everything.
        low: Low corner [2] of the free floor in [m].
        high: High corner [2] in [m].
        passage: Half the width of this plan's gaps in [m].
        bordered: Whether walls stand around the arena.
        detour: Length of ways in this plan over their straight lines, about.
        spread: Distance in [m] that goals and start keep from obstacles.
        start_area: Where the start lies.
        goal_areas: Where the first goals lie; the others anywhere outside `closed`.
        largest: Largest half size of what lies in `goal_areas`, in [m].
        closed: An area without start and keys.
        zone: A region to remain in.
        outside: Parts of the free floor's box that are not in the zone.
        varied: Whether regions may have any shape.
        polygons: How many more of them may be polygons.
    """

    measures: Measures
    random: np.random.Generator
    low: np.ndarray
    high: np.ndarray
    passage: float
    bordered: bool
    detour: float = 1.2
    spread: float = 0.0
    obstacles: list[Piece] = field(default_factory=list)
    doors: list[Door] = field(default_factory=list)
    start_area: Area | None = None
    goal_areas: list[Area] = field(default_factory=list)
    largest: float = np.inf
    closed: Area | None = None
    zone: Region | None = None
    outside: list[Region] = field(default_factory=list)
    varied: bool = False
    polygons: int = ROOM.polygons

    @property
    def unit(self) -> float:
        """A tenth of the arena in [m]."""
        return self.measures.unit

    @property
    def solid(self) -> list[Region]:
        """Obstacles, closed doors, and what is outside."""
        return [p.region for p in self.obstacles] + [d.region for d in self.doors] + self.outside

    @property
    def everywhere(self) -> Area:
        """The free floor."""
        return self.low, self.high

    def chance(self, probability: float) -> bool:
        """Whether an event of a probability happens."""
        return bool(self.random.random() < probability)

    def between(self, low: float, high: float) -> float:
        """A uniform number."""
        return float(self.random.uniform(low, high))

    def share(self, axis: int, share: float) -> float:
        """The coordinate at a share of the free floor along an axis."""
        return float(self.low[axis] + share * (self.high[axis] - self.low[axis]))

    def span(self, axis: int) -> float:
        """Length of the free floor along an axis in [m]."""
        return float(self.high[axis] - self.low[axis])

    def side(self, axis: int, low: float, high: float) -> Area:
        """The part of the free floor between two coordinates of an axis."""
        lows, highs = self.low.copy(), self.high.copy()
        lows[axis], highs[axis] = max(low, lows[axis]), min(high, highs[axis])
        return lows, highs

    def thickness(self) -> float:
        """Half the thickness of a wall in [m]: no step leaps over it."""
        least = max(0.25 * self.unit, 0.6 * self.measures.speed)
        return self.between(least, max(0.6 * self.unit, 1.2 * least))

    def block(self, x: Sequence[float], y: Sequence[float], tall: bool = True) -> None:
        """An obstacle between two coordinates of each axis."""
        name = f"O{len(self.obstacles) + 1}"
        self.obstacles.append(Piece(rectangle(name, x, y), tall))

    def wall(
        self,
        axis: int,
        at: float,
        gaps: Sequence[float],
        *,
        tall: bool = True,
        keys: Area | None = None,
    ) -> float:
        """A wall across the floor with gaps at coordinates along it; its half thickness in [m].

        With `keys` the gaps are doors.
        """
        half, along = self.thickness(), 1 - axis
        beyond = 0.1 * self.unit if self.bordered else 0.0
        marks = [self.low[along] - beyond]
        for gap in sorted(gaps):
            marks += [gap - self.passage, gap + self.passage]
        marks.append(self.high[along] + beyond)
        across = (at - half, at + half)
        for low, high in zip(marks[::2], marks[1::2], strict=True):
            if high - low >= SMALLEST_PIECE * self.unit:
                self.block(*_ordered(axis, across, (low, high)), tall=tall)
        if keys is not None:
            for gap in gaps:
                ends = (gap - self.passage, gap + self.passage)
                name = f"D{len(self.doors) + 1}"
                self.doors.append(Door(rectangle(name, *_ordered(axis, across, ends)), keys))
        return half

    def gap(self, axis: int, low: float = 0.0, high: float = 1.0) -> float:
        """A coordinate along a wall across an axis for a gap, between shares of the wall.

        The passage becomes narrower where the wall is short.

        Raises:
            UserError: the robot would not pass.
        """
        along, beside = 1 - axis, 0.3 * self.unit
        ends = self.share(along, low) + beside, self.share(along, high) - beside
        self.passage = min(self.passage, 0.4 * (ends[1] - ends[0]))
        if self.passage < self.measures.tight:
            raise UserError("the wall is too short for a gap")
        return self.between(ends[0] + self.passage, ends[1] - self.passage)

    def pillars(self, count: int, largest: float) -> None:
        """Up to `count` free-standing obstacles of half sizes up to `largest` units."""
        for _ in range(count):
            name = f"O{len(self.obstacles) + 1}"
            half = self.random.uniform(0.3, largest, 2) * self.unit
            if self.chance(0.5):
                outline = circle(name, (0.0, 0.0), float(half[0]))
            else:
                outline = rectangle(name, (-half[0], half[0]), (-half[1], half[1]))
            region = self.position(outline, self.everywhere, 2 * self.passage, self.solid, 20)
            if region is not None:
                self.obstacles.append(Piece(region, tall=False, free=True))

    def vary(self) -> None:
        """Let all that is placed from now on have any shape, and some pillars as well."""
        self.varied = True
        for number, piece in enumerate(self.obstacles):
            if piece.free and self.chance(VARIED):
                self.obstacles[number] = replace(piece, region=self.shaped(piece.region))

    def shaped(self, outline: Region) -> Region:
        """Another shape inside a circle or a rectangle."""
        region = varied(outline, self.random, polygons=self.polygons > 0)
        self.polygons -= region.kind == "polygon"
        return region

    def place(self, outline: Region, area: Area, spread: float, others: Sequence[Region]) -> Region:
        """A region at a random position of an area, apart from others.

        Raises:
            UserError: no place was found.
        """
        region = self.position(outline, area, spread, others, PLACES)
        if region is None:
            raise UserError(f"no place for {outline.name}")
        return region

    def position(
        self, outline: Region, area: Area, spread: float, others: Sequence[Region], tries: int
    ) -> Region | None:
        """As `place`, but None where no place was found."""
        half = half_extents(outline) + min(spread, self.measures.keep)  # from the borders too
        low, high = np.maximum(area[0], self.low + half), np.minimum(area[1], self.high - half)
        if (low > high).any():
            return None
        center = find_position(outline, (low, high), spread, others, tries, self.random)
        return None if center is None else outline.at(center.tolist())


def new_floor(measures: Measures, random: np.random.Generator, bordered: bool = True) -> Floor:
    """An empty floor; borders take a part of the arena, sometimes a large one."""
    low, high = np.array(measures.low[:2]), np.array(measures.high[:2])
    inset = random.uniform(0.03, 0.09, (2, 2))
    if random.random() < 0.2:
        inset[random.integers(2), random.integers(2)] = random.uniform(0.1, 0.22)
    inset = inset * (high - low) if bordered else np.full((2, 2), 0.02) * (high - low)
    passage = random.uniform(measures.tight, measures.wide)
    floor = Floor(measures, random, low + inset[0], high - inset[1], float(passage), bordered)
    floor.spread = measures.keep
    return floor


def _ordered(axis: int, across: tuple[float, float], along: tuple[float, float]):
    """(x, y) intervals of a wall across an axis."""
    return (across, along) if axis == 0 else (along, across)


Family = Callable[[Measures, np.random.Generator], Floor]
"""Draws obstacles and doors, and says where start, keys and goals may lie."""
