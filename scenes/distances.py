"""Margins of regions in double precision, without gradients and without compilation.

The same signed distances as in `scenes.margins` and `scenes.compound`, for judgements that are made
at every edit.
"""

import numpy as np

from scenes.polygons import signed_distance
from scenes.regions import Region


def margin_of(region: Region, positions: np.ndarray) -> np.ndarray:
    """Margins [P] of a region at positions [P, d] in [m]: >= 0 exactly inside."""
    if region.kind == "union":
        return np.max([margin_of(part, positions) for part in region.parts], axis=0)
    excess = _excesses(region, positions - np.array(region.center))
    outside = np.linalg.norm(np.maximum(excess, 0.0), axis=1)
    return -(outside + np.minimum(excess.max(axis=1), 0.0))


def _excesses(region: Region, offset: np.ndarray) -> np.ndarray:
    """Excesses [P, k] of offsets [P, d] in each independent direction."""
    size = np.array(region.size)
    match region.kind:
        case "circle" | "sphere":
            return np.linalg.norm(offset, axis=1)[:, None] - size
        case "cylinder":
            radial = np.linalg.norm(offset[:, :2], axis=1)
            return np.column_stack([radial, np.abs(offset[:, 2])]) - size
        case "polygon" | "prism":
            corners = np.array(region.points) - region.center[:2]
            sides = signed_distance(corners, offset[:, :2])
            return np.column_stack([sides, np.abs(offset[:, 2:]) - size[2:]])
        case "point":
            return np.linalg.norm(offset, axis=1)[:, None]
    if region.angle:
        (cosine, sine), (x, y) = region.turn, offset[:, :2].T
        flat = np.column_stack([cosine * x + sine * y, cosine * y - sine * x])
        offset = np.column_stack([flat, offset[:, 2:]])
    return np.abs(offset) - size
