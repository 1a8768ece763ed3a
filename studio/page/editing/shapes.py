"""From pointer to region: drawing by dragging on the floor, handles, and the grid they snap to.

Positions are in [m], d = 2 or 3. A shape is drawn on the floor (z = 0) and stands on it. A unit
is the length of the robot, so that shapes on a table are smaller than those in an arena.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

from scenes import Region
from studio.page.editing.corners import corners_of, with_corner

SMALLEST = 0.05
"""Smallest half extent or radius that the pointer can give a region, in units."""

HALF_HEIGHT = 0.5
"""Half the height of a new box or cylinder, in units."""

Position = tuple[float, ...]


class Outline(NamedTuple):
    """Center and size of a region [m]."""

    center: Position
    size: Position


def snap(values: Position, step: float) -> Position:
    """Nearest points of a grid with this step [m]; no grid for a step of 0."""
    if step <= 0:
        return tuple(float(value) for value in values)
    return tuple(round(round(value / step) * step, 9) for value in values)


def drawn(
    kind: str, start: Position, end: Position, step: float = 0.0, unit: float = 1.0
) -> Outline | None:
    """The region that a drag on the floor draws.

    A rectangle or box spans the drag; a circle, sphere or cylinder has its axis at the start and
    the end on its rim.

    Args:
        kind: of region.
        start: (x, y) where the drag began.
        end: (x, y) where it is now.
        step: of the grid [m].
        unit: [m].

    Returns:
        None for a drag that is too short to draw a region.
    """
    start, end = snap(start[:2], step), snap(end[:2], step)
    smallest, half_height = SMALLEST * unit, HALF_HEIGHT * unit
    if math.dist(start, end) < 2 * smallest:
        return None
    if kind in ("rectangle", "box"):
        center = tuple((a + b) / 2 for a, b in zip(start, end, strict=True))
        size = tuple(max(abs(a - b) / 2, smallest) for a, b in zip(start, end, strict=True))
    else:
        center, size = start, snap((math.dist(start, end),), step)
    match kind:
        case "box" | "cylinder":
            return Outline((*center, half_height), (*size, half_height))
        case "sphere":
            return Outline((*center, size[0]), size)
    return Outline(center, size)


def cornered(kind: str, corners: Sequence[tuple[float, float]], unit: float) -> Region:
    """A polygon, or a prism that stands on the floor, of corners that were clicked.

    Raises:
        UserError: too few corners, or the polygon crosses itself.
    """
    z = (0.0, 2 * HALF_HEIGHT * unit) if kind == "prism" else ()
    return Region("new", kind, points=tuple(corners), z=z)


def handles(region: Region) -> tuple[Position, ...]:
    """Points by which the region can be changed.

    Corners of a rectangle, polygon or prism, after which come the middles of the prism's ends; in
    all other cases points on the axes, low and high on x, then on y, then on z: of a circle or
    sphere, the middles of a box's faces, a cylinder's rim and its ends. A point and a union have
    none.
    """
    center, size = region.center, region.size
    if region.kind in ("point", "union"):
        return ()
    if region.points:
        return (*corners_of(region), *((*center[:2], level) for level in region.z))
    if region.angle:
        flat = handles(replace(region, angle=0.0))
        return tuple(_turned(region, point, 1) for point in flat)
    if region.kind == "rectangle":
        corners = product(*((-half, half) for half in size))
        return tuple(_plus(center, corner) for corner in corners)
    return _axis_points(center, half_extents(region))


def axis_of(region: Region, handle: int) -> int | None:
    """Axis along which a handle is dragged: 0, 1 or 2; None for one that is dragged on a level."""
    if region.dimension == 2 or handle < len(region.points):
        return None
    if region.points:
        return 2
    axis = handle // 2
    return None if region.angle and axis < 2 else axis


def reshaped(
    region: Region, handle: int, position: Position, step: float = 0.0, unit: float = 1.0
) -> Region:
    """The region after one of its `handles` was dragged to a position; see `resized`.

    A corner of a polygon or prism goes where the pointer is, unless the edges would cross.
    """
    if handle < len(region.points):
        x, y = snap(position[:2], step)
        return with_corner(region, handle, (x, y))
    if region.angle:
        flat = replace(region, angle=0.0)
        outline = resized(flat, handle, _turned(region, position, -1), step, unit)
        center = _turned(region, outline.center, 1)
    else:
        outline = resized(region, handle, position, step, unit)
        center = outline.center
    return region.sized(outline.size).at(center)


def resized(
    region: Region, handle: int, position: Position, step: float = 0.0, unit: float = 1.0
) -> Outline:
    """The region after one of its `handles` was dragged to a position.

    The opposite corner of a rectangle, the opposite face of a box, the axis of a round region and
    the other end of a cylinder stay where they are.

    Args:
        region: as it was before the drag.
        handle: index.
        position: of the pointer [m].
        step: of the grid [m].
        unit: [m].
    """
    position = snap(position, step)
    center, size = region.center, region.size
    grabbed, smallest = handles(region)[handle], SMALLEST * unit
    if region.kind == "rectangle":
        axes = zip(center, size, grabbed, position, strict=True)
        spans = [_span(*axis, smallest) for axis in axes]
        return Outline(tuple(span[0] for span in spans), tuple(span[1] for span in spans))
    axis = 2 if region.points else handle // 2
    if region.kind in ("box", "prism") or (region.kind == "cylinder" and axis == 2):
        entry = 1 if region.kind == "cylinder" else axis
        middle, half = _span(center[axis], size[entry], grabbed[axis], position[axis], smallest)
        return Outline(_with(center, axis, middle), _with(size, entry, half))
    flat = 2 if region.kind == "cylinder" else len(center)
    radius = max(snap((math.dist(center[:flat], position[:flat]),), step)[0], smallest)
    return Outline(center, (radius, *size[1:]))


def half_extents(region: Region) -> Position:
    """Half extents along the axes [d]."""
    return tuple(float(half) for half in region.half_extents)


def _turned(region: Region, point: Position, sense: int) -> Position:
    """A point turned about a region's centre by its angle, or back."""
    cosine, sine = region.turn[0], sense * region.turn[1]
    x, y = point[0] - region.center[0], point[1] - region.center[1]
    turned = cosine * x - sine * y, sine * x + cosine * y
    return (region.center[0] + turned[0], region.center[1] + turned[1], *point[2:])


def _with(values: Position, index: int, value: float) -> Position:
    return (*values[:index], value, *values[index + 1 :])


def _span(
    center: float, half: float, grabbed: float, position: float, smallest: float
) -> tuple[float, float]:
    """Middle and half length of an interval after one end was dragged, the other fixed."""
    side = 1.0 if grabbed > center else -1.0
    fixed = center - side * half
    new = max(side * (position - fixed) / 2, smallest)
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
