"""Simple polygons of the plane: which ones are accepted, their triangles and signed distances.

A polygon is a list of N corners in [m], in either sense of rotation, convex or not. It must not
touch or cross itself.
"""

import re
from collections.abc import Sequence

import numpy as np
import shapely

Corners = Sequence[Sequence[float]] | np.ndarray

MOST_CORNERS = 16
LEAST_GAP = 1e-6
"""Least distance of two corners in a row [m]."""


def flaw(corners: Corners) -> str:
    """Why corners make no polygon; empty if they make one."""
    count = len(corners)
    if not 3 <= count <= MOST_CORNERS:
        return f"{count} corners; a polygon has from 3 to {MOST_CORNERS}"
    points = np.array(corners, float)
    short = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1) < LEAST_GAP
    if short.any():
        return f"corner {short.argmax() + 1} and the next one are the same"
    outline = shapely.Polygon(points)
    if outline.is_valid:
        return ""
    place = re.search(r"\[(\S+) (\S+)\]", shapely.is_valid_reason(outline))
    where = f" at ({float(place[1]):.4g}, {float(place[2]):.4g})" if place else ""
    return f"its edges touch or cross{where}"


def counter_clockwise(corners: Corners) -> np.ndarray:
    """The corners [N, 2] in the mathematical sense of rotation."""
    points = np.array(corners, float)
    return points if shapely.LinearRing(points).is_ccw else points[::-1]


def triangles(corners: Corners) -> np.ndarray:
    """Triangles [K, 3, 2] that a polygon is made of, counter-clockwise."""
    pieces = shapely.constrained_delaunay_triangles(shapely.Polygon(corners))
    found = [shapely.get_coordinates(piece)[:3] for piece in shapely.get_parts(pieces)]
    return np.array([counter_clockwise(triangle) for triangle in found])


def signed_distance(corners: Corners, positions: np.ndarray) -> np.ndarray:
    """Distances [P] in [m] of positions [P, 2] from a polygon's boundary, negative inside."""
    outline, points = shapely.Polygon(corners), shapely.points(positions)
    shapely.prepare(outline)
    away = shapely.distance(outline.exterior, points)
    return np.where(shapely.contains(outline, points), -away, away)
