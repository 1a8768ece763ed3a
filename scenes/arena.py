"""The arena of a scene: the box in which its regions lie and ways are planned.

A scene has its robot's arena unless it asks for another. In that one, what the robot's workspace
says of lengths scales with

    s = (V / V0)^(1/d),

the ratio of the volumes V of the arena and V0 of the robot's. The grid of the distance fields
then has about as many nodes as the robot's. Their numbers along the axes follow the arena's
proportions in steps of a factor sqrt(2), so that most arenas of a robot share a few compiled
programs, and all squares (or cubes) one.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeGuard

import numpy as np

from envs import Robot, Workspace
from scenes.checks import LARGEST_COORDINATE, SceneError
from scenes.regions import Region

Arena = tuple[tuple[float, float], ...]
"""(low, high) of each axis in [m]."""

LONGEST_RATIO = 20
"""Longest side of an arena over its shortest."""

SHORTEST, LONGEST = 0.5, 100.0
"""Bounds of the longest side in lengths of the robot: what it is learnt with."""


def checked(arena: object, robot: Robot) -> Arena:
    """An arena that a scene asks for, as floats.

    Raises:
        SceneError: not an arena of the robot's dimension, out of proportion, or out of reach.
    """
    wanted = f"[[low, high], ...] in [m], one pair for each of {robot.position_size} axes"
    if not _is_pairs(arena, robot.position_size):
        raise SceneError(f"arena: {arena!r} must be {wanted}")
    shown = [list(pair) for pair in arena]
    if not all(-LARGEST_COORDINATE <= low < high <= LARGEST_COORDINATE for low, high in arena):
        raise SceneError(
            f"arena: {shown}: low must be below high, both at most {LARGEST_COORDINATE:g} m"
        )
    pairs = tuple((float(low), float(high)) for low, high in arena)
    sides = [high - low for low, high in pairs]
    if max(sides) > LONGEST_RATIO * min(sides):
        raise SceneError(
            f"arena: {shown}: the longest side may be {LONGEST_RATIO} times the shortest at most"
        )
    if not SHORTEST * robot.length <= max(sides) <= LONGEST * robot.length:
        raise SceneError(
            f"arena: {shown}: the longest side must be from {SHORTEST * robot.length:g} to "
            f"{LONGEST * robot.length:g} m for the robot {robot.name!r}"
        )
    reach = robot.workspace.reach
    if reach is not None and not _within(pairs, reach):
        raise SceneError(
            f"arena: {shown} leaves the reach of the robot {robot.name!r}, "
            f"{[list(pair) for pair in reach]}"
        )
    return pairs


def fitted(workspace: Workspace, arena: Arena) -> Workspace:
    """A robot's workspace in another arena."""
    if arena == workspace.arena:
        return workspace
    sides, scale = _sides(arena), scale_of(workspace, arena)
    return replace(
        workspace,
        arena=arena,
        spacing=float((sides / cells(workspace, arena)).max()),
        clearance=scale * workspace.clearance,
        inset=scale * workspace.inset,
    )


def holding(arena: Arena, regions: Sequence[Region], robot: Robot) -> Arena | None:
    """An arena that holds another and all regions; None if it would be the same, or not allowed."""
    found = hull(arena, regions)
    wider = tuple((float(np.floor(low)), float(np.ceil(high))) for low, high in found)
    try:
        return None if found == arena else checked(wider, robot)
    except SceneError:
        return None


def hull(arena: Arena, regions: Sequence[Region]) -> Arena:
    """The smallest box that contains an arena and some regions."""
    low, high = np.array(arena, float).T
    least = np.min([low, *(region.center - region.half_extents for region in regions)], axis=0)
    most = np.max([high, *(region.center + region.half_extents for region in regions)], axis=0)
    return tuple(zip(least.tolist(), most.tolist(), strict=True))


def scale_of(workspace: Workspace, arena: Arena) -> float:
    """Lengths in an arena over those in a robot's own."""
    return float(np.prod(_sides(arena) / _sides(workspace.arena)) ** (1 / len(arena)))


def round_scale(scale: float) -> float:
    """The largest of ..., 0.5, 1, 2, 5, 10, ... that is no more than a scale."""
    power = 10.0 ** np.floor(np.log10(scale) + 1e-9)
    return float(power * max(factor for factor in (1, 2, 5) if factor <= scale / power + 1e-9))


def cells(workspace: Workspace, arena: Arena) -> np.ndarray:
    """Cells [d] of the grid along each axis of an arena, for a robot with a workspace."""
    own = np.ceil(_sides(workspace.arena) / workspace.spacing - 1e-9)
    sides = _sides(arena)
    proportion = sides / np.prod(sides) ** (1 / len(sides))
    steps = np.ceil(2 * np.log2(proportion) - 1e-9)
    mean = np.prod(own) ** (1 / len(own))
    return np.maximum(np.ceil(mean * 2 ** (steps / 2) - 1e-9), 4).astype(int)


def _sides(arena: Arena) -> np.ndarray:
    low, high = np.array(arena, float).T
    return high - low


def _within(inner: Arena, outer: Sequence[tuple[float, float]]) -> bool:
    return all(o[0] <= i[0] and i[1] <= o[1] for i, o in zip(inner, outer, strict=True))


def _is_pairs(arena: object, axes: int) -> TypeGuard[Sequence[Sequence[float]]]:
    """Whether a value is a list of pairs of numbers, one an axis."""
    return (
        isinstance(arena, list | tuple)
        and len(arena) == axes
        and all(isinstance(pair, list | tuple) and len(pair) == 2 for pair in arena)
        and all(type(value) in (int, float) for pair in arena for value in pair)
    )
