"""The paths of moving regions as data, and regions where they are at a step.

A region is a shape that is moved as a whole: its margin at a position p and a step k is that of the
shape, where it begins, at p less the region's offset at k. So its rows and polygons are moved by
the offset, and everything else stays as it is.

Dimensions: U different paths (padded), T steps (padded), A regions, R rows of shapes, Q polygons, F
distance fields, d of the space.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from scenes.compound import padded
from scenes.margins import RegionArrays
from scenes.regions import SHAPES, Region

LEAST_PATHS = 4
"""Number that paths are padded to, doubled until it suffices."""


class Paths(NamedTuple):
    """How regions move, and which distance fields count when."""

    offset: jax.Array  # [U, T + 1, d] of each path at each step; the first one stands [m]
    shape: jax.Array  # [R] int32 path of each row
    outline: jax.Array  # [Q] int32 path of each polygon
    row: jax.Array  # [T + 1, F] int32 field that counts at a step
    drift: jax.Array  # [T + 1, F, d] way that its goal has gone since it was worked out [m]


def paths_of(regions: Sequence[Region], arrays: RegionArrays, steps: int) -> Paths:
    """The paths of regions for T steps; fields are for `scenes.snapshots` to add.

    Args:
        regions: some of which move.
        arrays: of the regions.
        steps: T.
    """
    motions = [None, *dict.fromkeys(region.motion for region in regions if region.motion)]
    dimension = arrays.center.shape[-1]
    offset = np.zeros((padded(len(motions), LEAST_PATHS), steps + 1, dimension), np.float32)
    for number, motion in enumerate(motions):
        if motion is not None:
            offset[number] = motion.offset(np.arange(steps + 1))
    outlines = 0 if arrays.compound is None else arrays.compound.corners.shape[0]
    shape = np.zeros(arrays.center.shape[0], np.int32)
    outline = np.zeros(outlines, np.int32)
    filled = {True: 0, False: 0}
    for region in regions:
        for piece in region.pieces:
            flat = piece.kind in SHAPES
            (shape if flat else outline)[filled[flat]] = motions.index(region.motion)
            filled[flat] += 1
    none = jnp.zeros((steps + 1, 0), jnp.int32)
    drift = jnp.zeros((*none.shape, dimension))
    return Paths(jnp.asarray(offset), jnp.asarray(shape), jnp.asarray(outline), none, drift)


def offsets(paths: Paths, step: jax.Array) -> jax.Array:
    """Offsets [U, d] of the paths at a step, or between two [m]."""
    last = paths.offset.shape[1] - 1
    step = jnp.clip(step, 0, last)
    before = jnp.floor(step).astype(jnp.int32)
    here, following = paths.offset[:, before], paths.offset[:, jnp.minimum(before + 1, last)]
    return here + (step - before) * (following - here)


def moved(arrays: RegionArrays, paths: Paths, step: Any) -> RegionArrays:
    """The regions where they are at a step, or between two."""
    offset = offsets(paths, step)
    arrays = arrays._replace(center=arrays.center + offset[paths.shape])
    if arrays.compound is None or not arrays.compound.corners.size:
        return arrays
    outline = offset[paths.outline]
    compound = arrays.compound._replace(corners=arrays.compound.corners + outline[:, None, :2])
    if outline.shape[1] > 2:
        height = compound.height.at[:, 0].add(outline[:, 2])
        compound = compound._replace(height=height)
    return arrays._replace(compound=compound)
