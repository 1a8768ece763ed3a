"""Outlines of regions as line segments."""

from itertools import combinations, product

import numpy as np

from scenes import Region

SEGMENTS = 64
"""Of a circle."""


def outline(region: Region, height: float) -> np.ndarray:
    """Segments [n, 2, 3] along the edges of a region; planar ones lie at a height [m]."""
    if region.kind == "union":
        return np.concatenate([outline(part, height) for part in region.parts])
    if region.kind in ("polygon", "prism"):
        return _walls(region, height)
    center = np.array([*region.center, height][:3])
    size = region.size
    match region.kind:
        case "rectangle":
            segments = _edges((size[0], size[1], 0.0))
        case "box":
            segments = _edges((size[0], size[1], size[2]))
        case "circle":
            segments = _circle(size[0])
        case "sphere":
            ring = _circle(size[0])
            segments = np.concatenate([ring, ring[..., [0, 2, 1]], ring[..., [2, 0, 1]]])
        case _:
            ring, up = _circle(size[0]), np.array([0.0, 0.0, size[1]])
            segments = np.concatenate([ring + up, ring - up])
    cosine, sine = region.turn
    turn = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0], [0.0, 0.0, 1.0]])
    return segments @ turn + center


def _walls(region: Region, height: float) -> np.ndarray:
    """Edges of a polygon; of a prism, those of its ends and between them."""
    corners = np.array(region.points)

    def ring(level: float) -> np.ndarray:
        return np.column_stack([corners, np.full(len(corners), level)])

    rings = [ring(level) for level in region.z or (height,)]
    edges = [np.stack([each, np.roll(each, -1, axis=0)], 1) for each in rings]
    return np.concatenate([*edges, np.stack(rings, 1)] if region.z else edges)


def _edges(half: tuple[float, float, float]) -> np.ndarray:
    """Edges of a box around the origin; a flat one has four."""
    corners = {tuple(np.multiply(signs, half)) for signs in product((-1.0, 1.0), repeat=3)}
    pairs = combinations(sorted(corners), 2)
    return np.array([pair for pair in pairs if np.sum(np.not_equal(*pair)) == 1])


def _circle(radius: float) -> np.ndarray:
    angle = np.linspace(0, 2 * np.pi, SEGMENTS + 1)
    points = radius * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
    return np.stack([points[:-1], points[1:]], axis=1)
