"""Regions of several parts: joined from regions, taken apart, changed part by part."""

from dataclasses import replace

import numpy as np

from core.errors import UserError
from scenes import Region
from scenes.distances import margin_of
from scenes.regions import MOST_PARTS

SAMPLES = 512
"""Positions along a ray through space that are looked at."""


def joined(region: Region, other: Region) -> Region:
    """A region of all parts of two, under the name and in the colour of the first.

    Raises:
        UserError: they have too many parts, or a part cannot be one.
    """
    parts = (*region.pieces, *other.pieces)
    if len(parts) > MOST_PARTS:
        raise UserError(
            f"{region.name} and {other.name} have {len(parts)} parts together; a region has at "
            f"most {MOST_PARTS}"
        )
    return Region(region.name, "union", color=region.color, parts=parts)


def with_part(union: Region, index: int, part: Region) -> Region:
    """The region with another shape as one of its parts."""
    return _of(union, (*union.parts[:index], part, *union.parts[index + 1 :]))


def without_part(union: Region, index: int) -> Region:
    """The region without one of its parts; the last one left is a region of its own kind."""
    return _of(union, (*union.parts[:index], *union.parts[index + 1 :]))


def apart(union: Region, names: tuple[str, ...]) -> tuple[Region, ...]:
    """Each part as a region with a name, all in the colour that they had together."""
    return tuple(
        replace(part, name=name, color=union.color)
        for part, name in zip(union.parts, names, strict=True)
    )


def part_met(union: Region, origin: np.ndarray, direction: np.ndarray) -> int:
    """Index of the part that a ray [3] from an origin [3] meets, or passes next to.

    In the plane it is followed to the floor.
    """
    if union.dimension == 2:
        reach = -origin[2] / direction[2] if direction[2] else 0.0
        seen = (origin + reach * direction)[None, :2]
    else:
        far = float(np.linalg.norm(np.array(union.center) - origin)) + 2 * max(union.size)
        unit = direction / np.linalg.norm(direction)
        seen = origin + np.linspace(0.0, far, SAMPLES)[:, None] * unit
    return int(np.argmax([margin_of(part, seen).max() for part in union.parts]))


def _of(union: Region, parts: tuple[Region, ...]) -> Region:
    if len(parts) == 1:
        return replace(parts[0], name=union.name, color=union.color)
    return replace(union, parts=parts, center=(), size=())
