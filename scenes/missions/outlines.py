"""Circles and rectangles of a floor plan."""

from collections.abc import Sequence

from scenes.regions import Region


def rectangle(name: str, x: Sequence[float], y: Sequence[float]) -> Region:
    """A rectangle between two coordinates of each axis."""
    center = (x[0] + x[1]) / 2, (y[0] + y[1]) / 2
    size = (x[1] - x[0]) / 2, (y[1] - y[0]) / 2
    return Region(name, "rectangle", tuple(map(float, center)), tuple(map(float, size)))


def circle(name: str, center: Sequence[float], radius: float) -> Region:
    """A circle."""
    return Region(name, "circle", tuple(map(float, center)), (float(radius),))
