"""Shapes of regions beside circles and rectangles along the axes."""

from collections.abc import Callable

import numpy as np

from scenes.missions.outlines import rectangle
from scenes.regions import Region

MOST_CORNERS = 7
"""Of a convex polygon."""


def varied(outline: Region, random: np.random.Generator, polygons: bool) -> Region:
    """A turned, polygonal or compound region inside a circle, or inside the box of a rectangle.

    Args:
        outline: a circle or a rectangle, whose name and centre the region has.
        random: draws the shape.
        polygons: whether it may be a polygon.
    """
    is_round = outline.kind == "circle"
    kinds = _KINDS[: None if polygons else 2]
    kind = kinds[random.integers(len(kinds))]
    half = np.array(outline.half_extents)
    if is_round and kind is not _convex:
        half = half / np.sqrt(2)
    return kind(outline.name, np.array(outline.center), half, random)


def _turned(name: str, center: np.ndarray, half: np.ndarray, random: np.random.Generator) -> Region:
    """A rectangle with an angle."""
    angle = round(float(random.uniform(10.0, 80.0)), 1)
    size = np.array([1.0, random.uniform(0.5, 1.0)])
    if random.random() < 0.5:
        size = size[::-1]
    cosine, sine = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    around = np.array([cosine * size[0] + sine * size[1], sine * size[0] + cosine * size[1]])
    size = size * float((half / around).min())
    sign = 1.0 if random.random() < 0.5 else -1.0
    return Region(name, "rectangle", tuple(center), tuple(size), angle=sign * angle)


def _cross(name: str, center: np.ndarray, half: np.ndarray, random: np.random.Generator) -> Region:
    """Two bars: a cross, a T or an L."""
    width = random.uniform(0.4, 0.55, 2) * half
    offset = random.choice([-1.0, 0.0, 1.0], 2) * (half - width)
    bars = []
    for axis in (0, 1):
        size, middle = half.copy(), center.copy()
        size[axis], middle[axis] = width[axis], center[axis] + offset[axis]
        bars.append(rectangle(name, *zip(middle - size, middle + size, strict=True)))
    return Region(name, "union", parts=tuple(bars))


def _convex(name: str, center: np.ndarray, half: np.ndarray, random: np.random.Generator) -> Region:
    """A convex polygon with corners on the ellipse inside the box."""
    count = int(random.integers(3, MOST_CORNERS + 1))
    turns = np.arange(count) + random.uniform(-0.25, 0.25, count)
    angles = 2 * np.pi * (turns / count + random.random())
    corners = center + half * np.column_stack([np.cos(angles), np.sin(angles)])
    return _polygon(name, corners)


def _ell(name: str, center: np.ndarray, half: np.ndarray, random: np.random.Generator) -> Region:
    """A polygon in the form of an L, one of two of them turned."""
    inner = random.uniform(-0.1, 0.15, 2)
    corners = np.array([[-1, -1], [1, -1], [1, inner[1]], [inner[0], inner[1]], [inner[0], 1]])
    corners = np.vstack([corners, [[-1, 1]]]) * random.choice([-1.0, 1.0], 2)
    if random.random() < 0.5:
        angle = random.uniform(0.0, 2 * np.pi)
        cosine, sine = np.cos(angle), np.sin(angle)
        corners = corners @ np.array([[cosine, sine], [-sine, cosine]])
        corners = corners / np.abs(corners).max(0)
    return _polygon(name, center + half * corners)


def _polygon(name: str, corners: np.ndarray) -> Region:
    return Region(name, "polygon", points=tuple(map(tuple, corners.tolist())))


_KINDS: tuple[Callable[..., Region], ...] = (_turned, _cross, _convex, _ell)
"""The polygons last."""
