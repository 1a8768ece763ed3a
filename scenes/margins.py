"""Signed distances from a position to the regions' boundaries, with their gradients.

The margin of a region at position p is mu(p) = -sd(p), sd the signed Euclidean distance to its
boundary: mu >= 0 exactly inside. All five kinds follow one formula. In terms of a region's
excesses q, one entry per independent direction,

    ball (circle, sphere)      q = (|p - c| - r)
    box (rectangle, box)       q = |p - c| - h, axis by axis
    cylinder                   q = (|p_xy - c_xy| - r, |p_z - c_z| - h)

    sd = ||max(q, 0)|| + min(max_i q_i, 0).

Turned shapes, polygons, prisms and unions are put together from such rows and from polygons
(`scenes.compound`), in scenes that have some; all others do without that code.

Dimensions: A regions (padded), R rows of shapes (padded), R = A without compound regions, d of the
space (2 or 3).
"""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from scenes.compound import (
    PADDING_MARGIN,
    Compound,
    Room,
    combined,
    compound_of,
    into,
    out_of,
    padded,
    shapes_of,
)
from scenes.regions import Region, SceneError

BALL, BOX, CYLINDER = 0, 1, 2
_CODES = {"circle": BALL, "sphere": BALL, "rectangle": BOX, "box": BOX, "cylinder": CYLINDER}
_UNUSED = -1e6  # excess of a direction that a kind does not have
_TINY = 1e-12  # squared length in [m^2] under which a direction counts as undefined


class RegionArrays(NamedTuple):
    """Regions as data, padded to a capacity, so that other regions need no compilation."""

    kind: jax.Array  # [R] int32: BALL, BOX or CYLINDER
    center: jax.Array  # [R, d] float32 [m]
    size: jax.Array  # [R, d] float32 [m], unused entries 0
    mask: jax.Array  # [R] bool: False on padding
    compound: Compound | None = None
    """How the regions are made of the rows; None where each is its row."""


def region_arrays(
    regions: tuple[Region, ...], dimension: int, capacity: int, room: Room | None = None
) -> RegionArrays:
    """Pack regions of one dimension, in order, into arrays for `capacity` regions.

    With `room`, all sets of regions that fit into it have arrays of the same shapes.
    """
    if len(regions) > capacity:
        raise SceneError(f"{len(regions)} regions are too many: at most {capacity} are allowed")
    for region in regions:
        if region.dimension != dimension:
            raise SceneError(
                f"region {region.name!r} is a {region.kind} of dimension {region.dimension}; "
                f"the workspace has dimension {dimension}"
            )
    if room is None and all(region.kind in _CODES and region.angle == 0 for region in regions):
        return _rows(regions, dimension, capacity)
    shapes = shapes_of(regions)
    count = padded(len(shapes), capacity)
    return _rows(shapes, dimension, count)._replace(
        compound=compound_of(regions, dimension, capacity, count, room)
    )


def _rows(regions: Sequence[Region], dimension: int, capacity: int) -> RegionArrays:
    """A row for each shape."""
    kind = np.zeros(capacity, np.int32)
    center = np.zeros((capacity, dimension), np.float32)
    size = np.zeros((capacity, dimension), np.float32)
    for row, region in enumerate(regions):
        kind[row] = _CODES[region.kind]
        center[row] = region.center
        size[row, : len(region.size)] = region.size
    mask = np.arange(capacity) < len(regions)
    return RegionArrays(
        jnp.asarray(kind), jnp.asarray(center), jnp.asarray(size), jnp.asarray(mask)
    )


def margins(arrays: RegionArrays, position: jax.Array) -> jax.Array:
    """Margins [A] in [m] at a position [d]; differentiable everywhere with finite gradients."""
    return margins_and_gradients(arrays, position)[0]


def margins_and_gradients(arrays: RegionArrays, position: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Margins [A] in [m] at a position [d] and their gradients [A, d], unit vectors.

    The gradient points into the region. On a kink (a ball's center, a box's diagonals) it is one
    of the limits, or zero at a center; on padding it is zero.
    """
    if arrays.compound is None:
        return _row_margins(arrays, position - arrays.center)
    offset = into(arrays.compound, position - arrays.center)
    margin, gradient = _row_margins(arrays, offset)
    return combined(arrays.compound, position, margin, out_of(arrays.compound, gradient))


def _row_margins(arrays: RegionArrays, offset: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Margins [R] and gradients [R, d] of the rows at offsets [R, d] from their centres."""
    excess, directions = _excesses(arrays, offset)
    positive = jnp.maximum(excess, 0.0)
    outside, outward = _length_and_direction(positive)
    largest = jnp.max(excess, axis=-1)
    inward = jax.nn.one_hot(jnp.argmax(excess, axis=-1), excess.shape[-1])
    distance = jnp.where(largest > 0.0, outside, largest)
    weights = jnp.where((largest > 0.0)[:, None], outward, inward)
    gradient = -jnp.einsum("ak,akd->ad", weights, directions)
    mask = arrays.mask
    return jnp.where(mask, -distance, PADDING_MARGIN), jnp.where(mask[:, None], gradient, 0.0)


def _excesses(arrays: RegionArrays, offset: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Excesses q [A, d] of offsets [A, d] and their gradients [A, d (of q), d (of p)]."""
    dimension = offset.shape[-1]
    length, unit = _length_and_direction(offset)
    sign = jnp.where(offset < 0.0, -1.0, 1.0)
    boxes = jnp.abs(offset) - arrays.size
    box_directions = sign[:, :, None] * jnp.eye(dimension)
    balls = jnp.full_like(offset, _UNUSED).at[:, 0].set(length - arrays.size[:, 0])
    ball_directions = jnp.zeros_like(box_directions).at[:, 0].set(unit)
    is_box = arrays.kind == BOX
    excess = jnp.where(is_box[:, None], boxes, balls)
    directions = jnp.where(is_box[:, None, None], box_directions, ball_directions)
    if dimension == 2:
        return excess, directions
    radial, radial_unit = _length_and_direction(offset.at[:, 2].set(0.0))
    axial = jnp.abs(offset[:, 2]) - arrays.size[:, 1]
    unused = jnp.full_like(axial, _UNUSED)
    cylinders = jnp.stack([radial - arrays.size[:, 0], axial, unused], axis=-1)
    zeros = jnp.zeros_like(radial_unit)
    cylinder_directions = jnp.stack([radial_unit, box_directions[:, 2], zeros], axis=-2)
    is_cylinder = arrays.kind == CYLINDER
    return (
        jnp.where(is_cylinder[:, None], cylinders, excess),
        jnp.where(is_cylinder[:, None, None], cylinder_directions, directions),
    )


def _length_and_direction(vectors: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Euclidean lengths [A] and unit vectors [A, d]; zero, with zero gradient, at the origin."""
    squared = jnp.sum(vectors**2, axis=-1)
    defined = squared > _TINY
    length = jnp.sqrt(jnp.where(defined, squared, 1.0))
    unit = jnp.where(defined[:, None], vectors / length[:, None], 0.0)
    return jnp.where(defined, length, 0.0), unit
