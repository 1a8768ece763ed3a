"""Turning regions about the vertical axis through a position.

Rectangles and boxes change their angle, polygons and prisms their corners, and of a union every
part goes round. What is round about its own axis has nothing to turn by.
"""

import math
from dataclasses import replace

from scenes import Region
from scenes.regions import TURNED

STEP = 5.0
"""Angles snap to multiples of it [degrees]."""

FINE = 0.1
"""Without snapping, angles are rounded to this [degrees]."""

OUTSIDE, DIAGONAL = 0.6, 0.4
"""How far outside the region its handle is, in the plane and in space, in units of the scene."""

TURNABLE = (*TURNED, "polygon", "prism", "union")
"""Kinds that have a handle to turn them by."""

Position = tuple[float, ...]


def turn_handle(region: Region, unit: float) -> Position | None:
    """Where a region is taken to turn it [d] in [m]; None for what cannot be turned.

    In the plane above the middle of the upper side, in space outside a corner, between the arrows;
    both go round with a region that has an angle.
    """
    if region.kind not in TURNABLE:
        return None
    flat = region if not region.angle else replace(region, angle=0.0)
    x, y = region.center[0], region.center[1]
    a, b = (float(half) for half in flat.half_extents[:2])
    if region.dimension == 2:
        here = (x, y + b + OUTSIDE * unit)
    else:
        here = (x + a + DIAGONAL * unit, y + b + DIAGONAL * unit, region.center[2])
    return rotated(here, region.angle, region.center)


def turned(region: Region, degrees: float, pivot: Position) -> Region:
    """A region turned counter-clockwise about the vertical axis through a position."""
    match region.kind:
        case "polygon" | "prism":
            points = tuple(rotated(point, degrees, pivot) for point in region.points)
            return replace(region, points=points, center=(), size=())
        case "union":
            parts = tuple(turned(part, degrees, pivot) for part in region.parts)
            return replace(region, parts=parts, center=(), size=())
    moved = region.at(rotated(region.center, degrees, pivot))
    if region.kind not in TURNED:
        return moved
    return replace(moved, angle=plain(region.angle + degrees))


def turn_between(region: Region, start: Position, end: Position, *, fine: bool = False) -> float:
    """By how much a drag from a position to another turns a region about its centre [degrees].

    Args:
        region: as it was before the drag.
        start: where it was taken [m].
        end: of the pointer [m].
        fine: whether it may have any angle, not only multiples of `STEP`.
    """
    by = _bearing(region.center, end) - _bearing(region.center, start)
    step = FINE if fine else STEP
    return plain(round((region.angle + by) / step) * step - region.angle)


def plain(degrees: float) -> float:
    """The same angle above -180 and up to 180 degrees."""
    return round(180.0 - (180.0 - degrees) % 360.0, 6)


def rotated(point: Position, degrees: float, pivot: Position) -> Position:
    """A position [d] turned about the vertical axis through another one; heights stay."""
    if degrees == 0:
        return tuple(point)
    angle = math.radians(degrees)
    x, y = point[0] - pivot[0], point[1] - pivot[1]
    turn = math.cos(angle), math.sin(angle)
    return (
        round(pivot[0] + turn[0] * x - turn[1] * y, 9),
        round(pivot[1] + turn[1] * x + turn[0] * y, 9),
        *point[2:],
    )


def _bearing(middle: Position, point: Position) -> float:
    return math.degrees(math.atan2(point[1] - middle[1], point[0] - middle[0]))
