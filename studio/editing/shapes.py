"""From pointer to region: drawing by a drag on the floor, handles, and the grid they snap to.

Positions are in [m], d = 2 or 3. A shape is drawn on the floor (z = 0) and stands on it.
"""

import math
from itertools import product
from typing import NamedTuple

from scenes import Region

SMALLEST = 0.05
"""Least half extent or radius that the pointer gives a region [m]."""

HALF_HEIGHT = 0.25
"""Half of the height that a new box or cylinder has [m]."""

Position = tuple[float, ...]


class Outline(NamedTuple):
    """Center and size of a region [m]."""

    center: Position
    size: Position


def snap(values: Position, step: float) -> Position:
    """Nearest points of a grid with this step [m]; a step of 0 is no grid."""
    if step <= 0:
        return tuple(float(value) for value in values)
    return tuple(round(round(value / step) * step, 9) for value in values)


def drawn(kind: str, start: Position, end: Position, step: float = 0.0) -> Outline | None:
    """The region that a drag on the floor draws.

    A rectangle or box spans the drag; a circle, sphere or cylinder has its axis at the start and
    the end on its rim.

    Args:
        kind: of region.
        start: (x, y) where the drag began.
        end: (x, y) where it is.
        step: of the grid.

    Returns:
        None for a drag too short to mean a region.
    """
    start, end = snap(start[:2], step), snap(end[:2], step)
    if math.dist(start, end) < 2 * SMALLEST:
        return None
    if kind in ("rectangle", "box"):
        center = tuple((a + b) / 2 for a, b in zip(start, end, strict=True))
        size = tuple(max(abs(a - b) / 2, SMALLEST) for a, b in zip(start, end, strict=True))
    else:
        center, size = start, snap((math.dist(start, end),), step)
    match kind:
        case "box" | "cylinder":
            return Outline((*center, HALF_HEIGHT), (*size, HALF_HEIGHT))
        case "sphere":
            return Outline((*center, size[0]), size)
    return Outline(center, size)


def handles(region: Region) -> tuple[Position, ...]:
    """Where the region can be grabbed to be resized.

    Corners of a rectangle or box; the ends of the axes of a circle or sphere; four points of the
    rim of a cylinder, then its bottom and top.
    """
    center, size = region.center, region.size
    if region.kind in ("rectangle", "box"):
        corners = product(*((-half, half) for half in size))
        return tuple(_plus(center, corner) for corner in corners)
    if region.kind == "cylinder":
        rim = _axis_points(center, (size[0], size[0]))
        return (*rim, *_axis_points(center, (0.0, 0.0, size[1]))[4:])
    return _axis_points(center, (size[0],) * len(center))


def resized(region: Region, handle: int, position: Position, step: float = 0.0) -> Outline:
    """The region after one of its `handles` was dragged to a position.

    The opposite corner of a rectangle or box, the axis of a round region, and the other end of a
    cylinder stay where they are.
    """
    position = snap(position, step)
    center, size = region.center, region.size
    grabbed = handles(region)[handle]
    if region.kind in ("rectangle", "box"):
        spans = [_span(*axis) for axis in zip(center, size, grabbed, position, strict=True)]
        return Outline(tuple(span[0] for span in spans), tuple(span[1] for span in spans))
    if region.kind == "cylinder" and handle >= 4:
        middle, half = _span(center[2], size[1], grabbed[2], position[2])
        return Outline((*center[:2], middle), (size[0], half))
    flat = 2 if region.kind == "cylinder" else len(center)
    radius = max(snap((math.dist(center[:flat], position[:flat]),), step)[0], SMALLEST)
    return Outline(center, (radius, *size[1:]))


def _span(center: float, half: float, grabbed: float, position: float) -> tuple[float, float]:
    """Middle and half length of an interval after one of its ends was dragged, the other fixed."""
    side = 1.0 if grabbed > center else -1.0
    fixed = center - side * half
    new = max(side * (position - fixed) / 2, SMALLEST)
    return fixed + side * new, new


def _axis_points(center: Position, reach: Position) -> tuple[Position, ...]:
    points = []
    for axis, length in enumerate(reach):
        for side in (-1.0, 1.0):
            offset = [0.0] * len(center)
            offset[axis] = side * length
            points.append(_plus(center, tuple(offset)))
    return tuple(points)


def _plus(center: Position, offset: Position) -> Position:
    return tuple(a + b for a, b in zip(center, offset, strict=True))
