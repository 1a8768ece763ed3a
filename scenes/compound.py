"""Regions that are more than a row of `scenes.margins`: turned, polygonal, or of several parts.

A turned shape is its row in coordinates turned back by its angle. The signed distance of a polygon
with N corners is the least distance to its edges, negative inside (`scenes.polygons`); with that
as its excess in the plane, a prism is

    q = (sd_polygon(p_xy), |p_z - c_z| - h),    sd = ||max(q, 0)|| + min(max_i q_i, 0).

A union's margin is the largest of its parts': exact outside and zero on the boundary; inside it is
no more than the depth.

Dimensions: A regions, M parts of a region, R rows of shapes, Q polygons, E corners (all padded), d
of the space.
"""

from collections.abc import Sequence
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from scenes.polygons import counter_clockwise
from scenes.regions import SHAPES, Region

PADDING_MARGIN = -1e3
"""Margin of a padding row in [m]: never inside."""

LEAST_POLYGONS, LEAST_CORNERS = 4, 8
"""Sizes that polygons are padded to, doubled until they suffice."""

_TINY = 1e-12  # squared length in [m^2] under which a direction counts as undefined
_ANY_HEIGHT = 1e6  # [m] half height of a polygon of the plane


class Room(NamedTuple):
    """Sizes that compound regions are padded to at least, whether there are any or not."""

    polygons: int
    corners: int
    parts: int


class Compound(NamedTuple):
    """How regions are made of turned shapes and polygons."""

    turn: jax.Array  # [R, 2] cosine and sine of the rows' angles
    corners: jax.Array  # [Q, E, 2] counter-clockwise, the last one repeated [m]
    height: jax.Array  # [Q, 2] middle and half height [m]
    parts: jax.Array  # [A, M] int32: rows, then R + polygons, that regions consist of, repeated
    used: jax.Array  # [A] bool: False on padding


def shapes_of(regions: Sequence[Region]) -> list[Region]:
    """The parts of regions that are rows, in order."""
    return [piece for region in regions for piece in region.pieces if piece.kind in SHAPES]


def compound_of(
    regions: Sequence[Region], dimension: int, capacity: int, rows: int, room: Room | None = None
) -> Compound:
    """Pack regions, for `capacity` of them with `rows` rows of shapes."""
    shapes, outlines, owner_of_shape, owner_of_outline = [], [], [], []
    for number, region in enumerate(regions):
        for piece in region.pieces:
            flat = piece.kind in SHAPES
            (shapes if flat else outlines).append(piece)
            (owner_of_shape if flat else owner_of_outline).append(number)
    if room is None:
        room = Room(LEAST_POLYGONS if outlines else 0, LEAST_CORNERS, 1)
    count = padded(len(outlines), room.polygons)
    most = max((len(piece.points) for piece in outlines), default=0)
    corners = np.zeros((count, padded(most, room.corners) if count else 0, 2), np.float32)
    height = np.tile(np.array([0.0, _ANY_HEIGHT], np.float32), (count, 1))
    for row, piece in enumerate(outlines):
        points = counter_clockwise(piece.points)
        corners[row] = points[np.minimum(np.arange(corners.shape[1]), len(points) - 1)]
        if dimension == 3:
            height[row] = piece.center[2], piece.size[2]
    turn = np.tile(np.array([1.0, 0.0], np.float32), (rows, 1))
    turn[: len(shapes)] = np.reshape([shape.turn for shape in shapes], (-1, 2))
    found: list[list[int]] = [[] for _ in regions]
    for row, number in enumerate(owner_of_shape):
        found[number].append(row)
    for row, number in enumerate(owner_of_outline):
        found[number].append(rows + row)
    parts = np.zeros((capacity, padded(max(map(len, found), default=1), room.parts)), np.int32)
    for number, own in enumerate(found):
        parts[number] = [own[min(i, len(own) - 1)] for i in range(parts.shape[1])]
    used = np.arange(capacity) < len(regions)
    return Compound(*(jnp.asarray(array) for array in (turn, corners, height, parts, used)))


def padded(count: int, least: int) -> int:
    """A size that programs are compiled for: doubled until it suffices."""
    while least < count:
        least *= 2
    return least


def into(compound: Compound, offset: jax.Array) -> jax.Array:
    """Offsets [R, d] in the coordinates of the rows."""
    return _turned(compound.turn * jnp.array([1.0, -1.0]), offset)


def out_of(compound: Compound, gradient: jax.Array) -> jax.Array:
    """Gradients [R, d] of the rows in coordinates of the world."""
    return _turned(compound.turn, gradient)


def combined(
    compound: Compound, position: jax.Array, margin: jax.Array, gradient: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Margins [A] in [m] and gradients [A, d] of regions at a position [d].

    Args:
        compound: what the regions consist of.
        position: in the world.
        margin: of the rows [R].
        gradient: of the rows [R, d].
    """
    if compound.corners.size:
        one = jax.vmap(_polygon_margin, (0, 0, None))
        own_margin, own_gradient = one(compound.corners, compound.height, position)
        margin = jnp.concatenate([margin, own_margin])
        gradient = jnp.concatenate([gradient, own_gradient])
    row, *others = compound.parts.T
    value = _rows_at(margin, row)
    for other in others:  # faster than a maximum over a table
        candidate = _rows_at(margin, other)
        row = jnp.where(candidate > value, other, row)
        value = jnp.maximum(candidate, value)
    return (
        jnp.where(compound.used, value, PADDING_MARGIN),
        jnp.where(compound.used[:, None], _rows_at(gradient, row), 0.0),
    )


def _rows_at(table: jax.Array, rows: jax.Array) -> jax.Array:
    """Rows of a table, all of which it has."""
    return table.at[rows].get(mode="promise_in_bounds")


def _turned(turn: jax.Array, vectors: jax.Array) -> jax.Array:
    """Vectors [R, d] turned about the vertical axis."""
    cosine, sine = turn[:, 0], turn[:, 1]
    x, y = vectors[:, 0], vectors[:, 1]
    flat = jnp.stack([cosine * x - sine * y, sine * x + cosine * y], -1)
    return jnp.concatenate([flat, vectors[:, 2:]], -1)


def _polygon_margin(
    corners: jax.Array, height: jax.Array, position: jax.Array
) -> tuple[jax.Array, jax.Array]:
    """Margin [] in [m] of a polygon or prism at a position [d], and its gradient [d]."""
    excess, outward = _signed_distance(corners, position[:2])
    if position.shape[0] == 2:
        return -excess, -outward
    level = position[2] - height[0]
    above = jnp.abs(level) - height[1]
    up = jnp.where(level < 0.0, -1.0, 1.0)
    squared = jnp.maximum(excess, 0.0) ** 2 + jnp.maximum(above, 0.0) ** 2
    length = jnp.sqrt(jnp.where(squared > _TINY, squared, 1.0))
    outside = jnp.maximum(excess, above) > 0.0
    is_side = excess >= above
    share = jnp.where(
        outside & (squared > _TINY),
        jnp.maximum(jnp.stack([excess, above]), 0.0) / length,
        jnp.stack([is_side, ~is_side]).astype(position.dtype),
    )
    distance = jnp.where(
        outside, jnp.where(squared > _TINY, length, 0.0), jnp.maximum(excess, above)
    )
    return -distance, -jnp.concatenate([share[0] * outward, share[1:] * up])


def _signed_distance(corners: jax.Array, position: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Distance [] from a polygon [E, 2] of the plane, negative inside, and its gradient [2]."""
    following = jnp.roll(corners, -1, axis=0)
    along, offset = following - corners, position - corners
    length = (along**2).sum(-1)
    share = (offset * along).sum(-1) / jnp.where(length > 0.0, length, 1.0)
    away = offset - jnp.clip(share, 0.0, 1.0)[:, None] * along
    squared = (away**2).sum(-1)
    nearest = squared.argmin()
    defined = squared[nearest] > _TINY
    distance = jnp.sqrt(jnp.where(defined, squared[nearest], 1.0))
    turn = along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]
    between = (corners[:, 1] <= position[1]) != (following[:, 1] <= position[1])
    inside = (between & ((turn > 0.0) == (along[:, 1] > 0.0))).sum() % 2 == 1
    sign = jnp.where(inside, -1.0, 1.0)
    edge = along[nearest] / jnp.sqrt(jnp.where(length[nearest] > 0.0, length[nearest], 1.0))
    normal = jnp.stack([edge[1], -edge[0]])  # outward; exact even close to the edge
    at_corner = (share[nearest] <= 0.0) | (share[nearest] >= 1.0)
    outward = jnp.where(defined & at_corner, sign * away[nearest] / distance, normal)
    return jnp.where(defined, sign * distance, 0.0), outward
