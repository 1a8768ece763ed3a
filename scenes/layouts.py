"""Other layouts of a scene: the same regions, moved, resized and mirrored.

Walls, that is boxes that cover a whole face of the workspace, stay. Obstacles that touch move
together, and only along the walls that they touch, so that chambers stay closed and pillars
stand from floor to ceiling; so do goals that overlap. Only regions that touch no other are
resized. Goals keep at least the clearance of planned paths from other goals and regions, or the
distance that they had.

Whether a layout leaves time for the task is for the caller to check.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np

from scenes.regions import Region
from scenes.scene import Scene
from scenes.world import GridWorld

ATTEMPTS = 50
"""Positions tried for a region before the whole layout is restarted."""

TOUCHING = 1e-6
"""Distance in [m] up to which regions touch: sums of decimals are not exact."""

RESTARTS = 5
"""Layouts started before shifts are made smaller."""


@dataclass(frozen=True)
class Perturbation:
    """How far layouts may differ from the original.

    Attributes:
        shift: Largest displacement along an axis, as a share of the workspace's extent.
        scale: Largest change of a size, as a share.
        mirror: Whether axes on which the workspace is symmetric are mirrored, with probability 1/2.
    """

    shift: float = 0.1
    scale: float = 0.1
    mirror: bool = True


class _Group(NamedTuple):
    """Regions that move together."""

    regions: tuple[Region, ...]
    free: np.ndarray  # [d] axes along which they may move
    goal: bool  # whether they are to be visited or started from


def perturbed(
    scene: Scene,
    goals: Collection[str],
    world: GridWorld,
    random: np.random.Generator,
    perturbation: Perturbation | None = None,
) -> Scene:
    """A random layout of a scene; the scene itself, perhaps mirrored, if no other fits.

    Args:
        scene: the regions.
        goals: names of the regions that the robot must visit.
        world: the workspace.
        random: draws the layout.
        perturbation: how far regions move; the default of `Perturbation` if None.
    """
    perturbation = Perturbation() if perturbation is None else perturbation
    low, high = world.limits
    if perturbation.mirror:
        scene = _mirrored(scene, (random.random(low.size) < 0.5) & np.isclose(low, -high))
    standing = walls(scene, world)
    groups = _groups(scene, goals, standing, low, high)
    shift = perturbation.shift * (high - low)
    for attempt in range(RESTARTS * 8):
        extent = shift * 0.7 ** (attempt // RESTARTS)
        found = _arrange(groups, standing, world, (low, high), extent, perturbation.scale, random)
        if found is not None:
            moved = {id(before): after for before, after in found}
            regions = tuple(moved.get(id(region), region) for region in scene.regions)
            return replace(scene, regions=regions, initial=moved[id(scene.initial)])
    return scene


def walls(scene: Scene, world: GridWorld) -> list[Region]:
    """Boxes that stand and cover a whole face of the workspace."""
    low, high = world.limits
    standing = [region for region in scene.regions if region.motion is None]
    return [region for region in standing if _faces(region, low, high).any()]


def separation(first: Region, second: Region) -> float:
    """Distance in [m] between two regions, negative or 0 where they touch.

    Cylinders, turned shapes and polygons count as the boxes around them, and so does each part of a
    union, so the distance is never overestimated.
    """
    pairs = product(first.pieces, second.pieces)
    return min(_separation(one, other) for one, other in pairs)


def _separation(first: Region, second: Region) -> float:
    offset = np.abs(np.subtract(first.center, second.center))
    radius = 0.0
    for region in (first, second):
        if region.kind in ("circle", "sphere"):
            radius += region.size[0]
        else:
            offset = offset - half_extents(region)
    if offset.max() <= 0:
        return float(offset.max()) - radius
    return float(np.linalg.norm(np.maximum(offset, 0.0))) - radius


def half_extents(region: Region) -> np.ndarray:
    """Half sides [d] in [m] of the box around a region."""
    return region.half_extents


def _faces(region: Region, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Faces of the workspace [2, d], low ones first, that a box covers completely, to 2 %."""
    if region.kind not in ("rectangle", "box") or region.angle:
        return np.zeros((2, len(low)), bool)
    slack = 0.02 * (high - low)
    center, half = np.asarray(region.center), half_extents(region)
    below, above = center - half <= low + slack, center + half >= high - slack
    spans = below & above
    others = np.array([np.delete(spans, axis).all() for axis in range(len(low))])
    return np.stack([below & others & ~spans, above & others & ~spans])


def _free_axes(
    region: Region, standing: list[Region], low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Axes [d] along which a region may move: those that lead to no wall it touches."""
    free = np.ones(len(low), bool)
    for wall in standing:
        if separation(region, wall) <= TOUCHING:
            free &= ~_faces(wall, low, high).any(0)
    return free


def _groups(
    scene: Scene, goals: Collection[str], standing: list[Region], low: np.ndarray, high: np.ndarray
) -> list[_Group]:
    """Regions that move together; obstacles first, since goals are easily placed among them."""

    def group(regions: list[Region], goal: bool) -> _Group:
        free = [_free_axes(region, standing, low, high) for region in regions]
        return _Group(tuple(regions), np.all(free, axis=0), goal)

    wanted = [region for region in scene.regions if region.name in goals]
    others = [r for r in scene.regions if r not in wanted and r not in standing]
    return [
        *(group(regions, False) for regions in _touching(others)),
        *(group(regions, True) for regions in _touching(wanted)),
        group([scene.initial], True),
    ]


def _touching(regions: list[Region]) -> list[list[Region]]:
    """Group the regions that touch."""
    groups: list[list[Region]] = []
    for region in regions:
        near = [g for g in groups if any(separation(region, other) <= TOUCHING for other in g)]
        groups = [g for g in groups if g not in near]
        groups.append([region, *(other for g in near for other in g)])
    return groups


def _arrange(
    groups: Sequence[_Group],
    standing: list[Region],
    world: GridWorld,
    workspace: tuple[np.ndarray, np.ndarray],
    extent: np.ndarray,
    scale: float,
    random: np.random.Generator,
) -> list[tuple[Region, Region]] | None:
    """Every region before and after; None if one could not be placed.

    Shifts are uniform in [-extent, extent] [d], [m].
    """
    placed = [(wall, wall, False) for wall in standing]
    clearance = world.clearance + world.inset

    def fits(before: Region, after: Region, goal: bool) -> bool:
        center = np.asarray(after.center)
        if (center < workspace[0]).any() or (center > workspace[1]).any():
            return False
        return all(
            separation(after, other) >= min(clearance, separation(before, was)) - 1e-9
            for was, other, is_goal in placed
            if goal or is_goal
        )

    for group in groups:
        for _ in range(ATTEMPTS):
            shift = random.uniform(-extent, extent) * group.free
            moved = [_moved(region, shift) for region in group.regions]
            if len(moved) == 1:
                moved = [_resized(moved[0], group.free, scale, random)]
            pairs = list(zip(group.regions, moved, strict=True))
            if all(fits(before, after, group.goal) for before, after in pairs):
                placed += [(before, after, group.goal) for before, after in pairs]
                break
        else:
            return None
    return [(before, after) for before, after, _ in placed]


def _moved(region: Region, shift: np.ndarray) -> Region:
    return region.at((np.asarray(region.center) + shift).tolist())


def _resized(region: Region, free: np.ndarray, scale: float, random: np.random.Generator) -> Region:
    """Scale the sizes along free axes, each by its own factor."""
    if region.kind in ("union", "point"):
        return region
    match region.kind:
        case "circle" | "sphere":
            may = np.array([free.all()])
        case "cylinder":
            may = np.array([free[:2].all(), free[2]])
        case "rectangle" | "box" if region.angle:
            may = np.array([free[:2].all(), free[:2].all(), *free[2:]])
        case _:
            may = free
    factor = np.where(may, 1 + random.uniform(-scale, scale, may.size), 1.0)
    return region.sized((np.asarray(region.size) * factor).tolist())


def _mirrored(scene: Scene, axes: np.ndarray) -> Scene:
    """The scene with the sign of the coordinates on some axes [d] flipped."""
    sign = np.where(axes, -1.0, 1.0)

    regions = tuple(region.mirrored(sign) for region in scene.regions)
    return replace(scene, regions=regions, initial=scene.initial.mirrored(sign))
