"""Simple polygons of the plane: which ones are accepted, their triangles and signed distances.

A polygon is a list of N corners in [m], in either sense of rotation, convex or not. It must not
touch or cross itself.

The signed distance from p to its boundary, negative inside, is the least distance to an edge, with
the sign of the number of edges that a ray from p crosses (even outside, odd inside).
"""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

Corners = Sequence[Sequence[float]] | np.ndarray

MOST_CORNERS = 16
LEAST_GAP = 1e-6
"""Least distance of a corner from the edges that it does not belong to [m]."""


def flaw(corners: Corners) -> str:
    """Why corners make no polygon; empty if they make one."""
    count = len(corners)
    if not 3 <= count <= MOST_CORNERS:
        return f"{count} corners; a polygon has from 3 to {MOST_CORNERS}"
    points = np.array(corners, float)
    following = np.roll(points, -1, axis=0)
    short = np.linalg.norm(following - points, axis=1) < LEAST_GAP
    if short.any():
        return f"corner {short.argmax() + 1} and the next one are the same"
    for i, j in combinations(range(count), 2):
        if j - i == 1 or i + count - j == 1:
            first, second = (i, j) if j - i == 1 else (j, i)
            if _folded(points[first], points[second], following[second]):
                return f"the edges at corner {second + 1} lie on each other"
        elif _gap(points[i], following[i], points[j], following[j]) < LEAST_GAP:
            return f"its edges from corner {i + 1} and from corner {j + 1} touch or cross"
    return ""


def counter_clockwise(corners: Corners) -> np.ndarray:
    """The corners [N, 2] in the mathematical sense of rotation."""
    points = np.array(corners, float)
    return points if area(points) > 0 else points[::-1]


def area(points: np.ndarray) -> float:
    """Area of a polygon [N, 2] in [m^2], negative if its corners run clockwise."""
    return float(_cross(points, np.roll(points, -1, axis=0)).sum() / 2)


def triangles(corners: Corners) -> np.ndarray:
    """Triangles [K, 3, 2] that a polygon is made of, counter-clockwise, by cutting off ears."""
    left = list(counter_clockwise(corners))
    found = []
    while len(left) > 3:
        ear = _ear(left)
        found.append((left[ear - 1], left[ear], left[(ear + 1) % len(left)]))
        del left[ear]
    kept = np.array([*found, tuple(left)])
    return kept[_cross(kept[:, 1] - kept[:, 0], kept[:, 2] - kept[:, 0]) > 0]


def signed_distance(corners: Corners, positions: np.ndarray) -> np.ndarray:
    """Distances [P] in [m] of positions [P, 2] from a polygon's boundary, negative inside."""
    points = np.array(corners, float)
    following = np.roll(points, -1, axis=0)
    along, offset = following - points, positions[:, None] - points
    share = (offset * along).sum(-1) / (along**2).sum(-1)
    away = offset - np.clip(share, 0, 1)[..., None] * along
    distance = np.linalg.norm(away, axis=-1).min(1)
    level = positions[:, None, 1]
    between = (points[:, 1] <= level) != (following[:, 1] <= level)
    left = (_cross(along, offset) > 0) == (along[:, 1] > 0)
    inside = (between & left).sum(1) % 2 == 1
    return np.where(inside, -distance, distance)


def _ear(left: list[np.ndarray]) -> int:
    """Index of a corner whose neighbours see each other inside, or that lies between them."""
    points = np.array(left)
    before, after = np.roll(points, 1, axis=0), np.roll(points, -1, axis=0)
    turn = _cross(points - before, after - points)
    straight = np.abs(turn) <= 1e-12 * np.abs(points - points.mean(0)).max() ** 2
    if straight.any():
        return int(straight.argmax())
    for i in np.flatnonzero(turn > 0):
        triangle = np.array([before[i], points[i], after[i]])
        others = np.delete(points, [i - 1, i, (i + 1) % len(points)], axis=0)
        if not (signed_distance(triangle, others) <= 0).any():
            return int(i)
    return int(turn.argmax())  # by rounding only: every simple polygon has two ears


def _folded(before: np.ndarray, corner: np.ndarray, after: np.ndarray) -> bool:
    """Whether the way turns back on itself at a corner."""
    if (before - corner) @ (after - corner) <= 0:
        return False
    return min(_away(after, corner, before), _away(before, corner, after)) < LEAST_GAP


def _gap(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> float:
    """Distance of the segments ab and cd [m]."""
    sides = _cross(b - a, c - a) * _cross(b - a, d - a), _cross(d - c, a - c) * _cross(d - c, b - c)
    if max(sides) < 0:
        return 0.0
    return min(_away(c, a, b), _away(d, a, b), _away(a, c, d), _away(b, c, d))


def _away(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    """Distance of a point from the segment ab [m]."""
    along = b - a
    share = np.clip((point - a) @ along / (along @ along), 0, 1)
    return float(np.linalg.norm(point - a - share * along))


def _cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """The z component of the cross products of vectors [..., 2]."""
    return first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
