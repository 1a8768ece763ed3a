"""Random positions of a region of the plane, apart from others; many are tried at once."""

from collections.abc import Sequence

import numpy as np

from scenes.distances import margin_of
from scenes.layouts import half_extents
from scenes.regions import Region


def find_position(
    outline: Region,
    corners: tuple[np.ndarray, np.ndarray],
    spread: float,
    others: Sequence[Region],
    tries: int,
    random: np.random.Generator,
) -> np.ndarray | None:
    """The first of some uniform positions [2] at which a region is apart from others, if any.

    Args:
        outline: the region, wherever it is.
        corners: low and high corner [2] of the positions.
        spread: least distance to the others in [m].
        others: regions of the plane.
        tries: number of positions.
        random: draws them.
    """
    positions = random.uniform(*corners, (tries, 2))
    free = (separations(outline, positions, others) >= spread).all(-1)
    return positions[free.argmax()] if free.any() else None


def separations(outline: Region, positions: np.ndarray, others: Sequence[Region]) -> np.ndarray:
    """Distances [T, O] from a region at positions [T, 2] to others, as `layouts.separation`.

    The distance to turned, polygonal and compound regions is that from a ball around the region.
    """
    plain = [other for other in others if _is_plain(other)]
    found = _plain_separations(outline, positions, plain)
    if len(plain) == len(others):
        return found
    radius = float(
        outline.size[0] if outline.kind == "circle" else np.linalg.norm(half_extents(outline))
    )
    rest = [other for other in others if not _is_plain(other)]
    away = [-margin_of(other, positions) - radius for other in rest]
    return np.column_stack([found, *away])


def _plain_separations(
    outline: Region, positions: np.ndarray, others: Sequence[Region]
) -> np.ndarray:
    if not others:
        return np.full((len(positions), 0), np.inf)
    half, radius = _box_and_ball(outline)
    boxes, balls = zip(*map(_box_and_ball, others), strict=True)
    centers = np.array([other.center for other in others])
    offset = np.abs(positions[:, None] - centers) - half - np.array(boxes)
    largest = offset.max(-1)
    outside = np.linalg.norm(np.maximum(offset, 0.0), axis=-1)
    return np.where(largest <= 0, largest, outside) - radius - np.array(balls)


def _box_and_ball(region: Region) -> tuple[np.ndarray, float]:
    """Half sides [2] and radius whose sum a region is."""
    if region.kind == "circle":
        return np.zeros(2), region.size[0]
    return half_extents(region), 0.0


def _is_plain(region: Region) -> bool:
    return region.kind in ("circle", "rectangle", "point") and region.angle == 0
