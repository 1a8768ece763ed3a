"""Random regions of every kind, and the same as geometries of shapely."""

import numpy as np
import shapely
from shapely import affinity
from shapely.geometry.base import BaseGeometry

from scenes import Region

ROUND = 4096
"""Segments of a quarter of a circle."""


def star(random: np.random.Generator, count: int) -> tuple[tuple[float, float], ...]:
    """Corners of a random polygon: each is seen from one place inside, at growing angles."""
    gaps = random.uniform(0.3, 1.0, count)
    angles = 2 * np.pi * np.cumsum(gaps / gaps.sum())
    radii = random.uniform(0.3, 2.0, count)
    corners = np.stack([radii * np.cos(angles), radii * np.sin(angles)], -1)
    corners = (corners + random.uniform(-2, 2, 2))[:: random.choice([-1, 1])]
    return tuple((float(x), float(y)) for x, y in corners)


def planar(random: np.random.Generator) -> list[Region]:
    """A region of each kind of the plane."""
    polygons = [Region("P", "polygon", points=star(random, n)) for n in (3, 5, 9, 16)]
    turned = [
        Region("R", "rectangle", _pair(random, -2, 2), _pair(random, 0.1, 2), angle=angle)
        for angle in (random.uniform(-360, 360), 90.0, 180.0)
    ]
    circle = Region("C", "circle", _pair(random, -2, 2), (float(random.uniform(0.2, 1)),))
    plain = Region("B", "rectangle", _pair(random, -2, 2), _pair(random, 0.1, 2))
    union = Region("U", "union", parts=(polygons[1], turned[0], circle, plain))
    return [*polygons, *turned, circle, plain, union]


def spatial(region: Region, low: float, high: float) -> Region:
    """A region of the plane from a height to another."""
    z = (low + high) / 2, (high - low) / 2
    match region.kind:
        case "polygon":
            return Region(region.name, "prism", points=region.points, z=(low, high))
        case "union":
            parts = tuple(spatial(part, low, high) for part in region.parts)
            return Region(region.name, "union", parts=parts)
        case "circle":
            kind, size = "cylinder", (region.size[0], z[1])
        case _:
            kind, size = "box", (*region.size, z[1])
    return Region(region.name, kind, (*region.center, z[0]), size, angle=region.angle)


def shape(region: Region) -> BaseGeometry:
    """The footprint of a region."""
    match region.kind:
        case "polygon" | "prism":
            return shapely.Polygon(region.points)
        case "circle" | "cylinder":
            return shapely.Point(region.center[:2]).buffer(region.size[0], quad_segs=ROUND)
        case "union":
            return shapely.union_all([shape(part) for part in region.parts])
    (x, y), (a, b) = region.center[:2], region.size[:2]
    return affinity.rotate(shapely.box(x - a, y - b, x + a, y + b), region.angle, (x, y))


def depth(region: Region, positions: np.ndarray) -> np.ndarray:
    """Signed distances [P] in [m] of positions [P, 2] from a footprint's boundary, inside > 0."""
    outline, points = shape(region), shapely.points(positions)
    away = shapely.distance(outline.boundary, points)
    return np.where(shapely.contains(outline, points), away, -away)


def _pair(random: np.random.Generator, low: float, high: float) -> tuple[float, float]:
    x, y = random.uniform(low, high, 2)
    return float(x), float(y)
