"""Corners of polygons and prisms: moved, added between two others, taken away."""

from dataclasses import replace

from core.errors import UserError
from scenes import Region
from scenes.polygons import MOST_CORNERS, flaw

Corner = tuple[float, float]
Position = tuple[float, ...]


def corners_of(region: Region) -> tuple[Position, ...]:
    """Corners [d] in [m] of a polygon, or of a prism at half its height; of all others, none."""
    return tuple((*point, *region.center[2:]) for point in region.points)


def middles_of(region: Region) -> tuple[Position, ...]:
    """The middles [d] in [m] of the edges, from each corner to the next: places of new corners.

    None where there are corners enough already.
    """
    corners = corners_of(region)
    if len(corners) == MOST_CORNERS:
        return ()
    pairs = zip(corners, (*corners[1:], *corners[:1]), strict=True)
    return tuple(
        tuple((a + b) / 2 for a, b in zip(one, other, strict=True)) for one, other in pairs
    )


def with_corner(region: Region, index: int, corner: Corner) -> Region:
    """The region with a corner moved; unchanged if its edges would cross."""
    points = (*region.points[:index], corner, *region.points[index + 1 :])
    return region if flaw(points) else with_points(region, points)


def with_new_corner(region: Region, edge: int, corner: Corner) -> Region:
    """The region with another corner on the edge that follows a corner; see `with_corner`."""
    points = (*region.points[: edge + 1], corner, *region.points[edge + 1 :])
    return region if flaw(points) else with_points(region, points)


def without_corner(region: Region, index: int) -> Region:
    """The region without one of its corners.

    Raises:
        UserError: three corners are left, or what is left would cross itself.
    """
    points = (*region.points[:index], *region.points[index + 1 :])
    if problem := flaw(points):
        raise UserError(f"without this corner: {problem}")
    return with_points(region, points)


def with_points(region: Region, points: tuple[Corner, ...]) -> Region:
    """The region with other corners."""
    return replace(region, points=points, center=(), size=())
