"""Uniform positions of initial sets that are turned, polygonal, or of several parts.

Such a set is a list of cells, each an affine image of a unit cell: of the box [-1, 1]^d, of a ball
of some axes times the box of the others, or of a triangle (in space, times [-1, 1]). A cell is
drawn by its share of the volume, then a position in it. Where the parts of a union overlap, a
position counts for the first part that it lies in and is drawn again for the others, so that it
remains uniform.

Dimensions: K cells (padded), d of the space.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from scenes.compound import padded
from scenes.distances import margin_of
from scenes.margins import RegionArrays, margins, region_arrays
from scenes.polygons import triangles
from scenes.regions import SHAPES, Region

LEAST_CELLS, LEAST_PARTS = 16, 4
"""Sizes that cells and parts are padded to, doubled until they suffice."""


class Cells(NamedTuple):
    """An initial set."""

    share: jax.Array  # [K] of the volume that the cells up to this one have
    origin: jax.Array  # [K, d] [m]
    axes: jax.Array  # [K, d, d] rows: images of the unit vectors [m]
    is_round: jax.Array  # [K, d] 1 for the axes in which the unit cell is a ball
    is_triangle: jax.Array  # [K] bool: whether the first two axes are a triangle
    part: jax.Array  # [K] int32 index of the part that a cell belongs to
    middle: jax.Array  # [d] a position well inside [m]
    parts: RegionArrays | None
    """Of a union, whose parts may overlap."""


class _Cell(NamedTuple):
    """A cell on the host."""

    origin: np.ndarray
    axes: np.ndarray
    is_round: np.ndarray
    is_triangle: bool
    volume: float


def round_axes(region: Region) -> np.ndarray:
    """[d] 1 for the axes in which a region is a ball, 0 for those in which it is a box."""
    match region.kind:
        case "circle" | "sphere":
            return np.ones(region.dimension, np.float32)
        case "cylinder":
            return np.array([1.0, 1.0, 0.0], np.float32)
    return np.zeros(region.dimension, np.float32)


def inner_point(region: Region) -> np.ndarray:
    """A position [d] well inside a region [m]: its centre, if that is."""
    if region.kind in SHAPES or region.kind == "point":
        return np.array(region.center)
    candidates = [region.center]
    for piece in region.pieces:
        candidates += [_middle(cell) for cell in _cells(piece)]
    positions = np.array(candidates)
    return positions[margin_of(region, positions).argmax()]


def cells_of(region: Region) -> Cells | None:
    """The cells of a region; None for one that is a box, a ball, a cylinder or a point."""
    if region.angle == 0 and (region.kind in SHAPES or region.kind == "point"):
        return None
    pairs = [(i, cell) for i, piece in enumerate(region.pieces) for cell in _cells(piece)]
    part, cells = np.array([i for i, _ in pairs]), [cell for _, cell in pairs]
    count, dimension = padded(len(cells), LEAST_CELLS), region.dimension
    volume = np.cumsum([cell.volume for cell in cells])
    several = len(region.parts) > 1

    def fill(values: Any, *shape: int) -> jax.Array:
        table = np.zeros((count, *shape), np.float32)
        table[: len(cells)] = values
        return jnp.asarray(table)

    return Cells(
        jnp.asarray(np.append(volume / volume[-1], np.ones(count - len(cells))), jnp.float32),
        fill([cell.origin for cell in cells], dimension),
        fill([cell.axes for cell in cells], dimension, dimension),
        fill([cell.is_round for cell in cells], dimension),
        fill([cell.is_triangle for cell in cells]) > 0,
        fill(part).astype(jnp.int32),
        jnp.asarray(inner_point(region), jnp.float32),
        region_arrays(region.parts, dimension, padded(len(region.parts), LEAST_PARTS))
        if several
        else None,
    )


def draw(cells: Cells, key: jax.Array) -> jax.Array:
    """A position [d] of the set, uniform [m]."""
    if cells.parts is None:
        return _draw_once(cells, key)[0]
    parts = cells.parts
    rank = jnp.arange(parts.mask.shape[0] if parts.compound is None else len(parts.compound.used))

    def again(state: tuple[jax.Array, jax.Array, jax.Array]) -> tuple:
        next_key, draw_key = jax.random.split(state[0])
        position, part = _draw_once(cells, draw_key)
        earlier = (margins(parts, position) >= 0.0) & (rank < part)
        return next_key, position, ~earlier.any()

    start = key, jnp.zeros_like(cells.middle), jnp.array(False)
    return jax.lax.while_loop(lambda state: ~state[2], again, start)[1]


def _draw_once(cells: Cells, key: jax.Array) -> tuple[jax.Array, jax.Array]:
    """A position [d] of the cells, and the part that its cell belongs to."""
    cell_key, box_key, angle_key, radius_key = jax.random.split(key, 4)
    last = cells.share.shape[0] - 1
    cell = jnp.minimum((cells.share <= jax.random.uniform(cell_key)).sum(), last)
    is_round, dimension = cells.is_round[cell], cells.middle.shape[0]
    box = jax.random.uniform(box_key, (dimension,), minval=-1.0, maxval=1.0)
    direction = jax.random.normal(angle_key, (dimension,)) * is_round
    direction = direction / jnp.maximum(jnp.linalg.norm(direction), 1e-9)
    radius = jax.random.uniform(radius_key) ** (1 / jnp.maximum(is_round.sum(), 1))
    unit = jnp.where(is_round > 0, radius * direction, box)
    half = (unit[:2] + 1) / 2  # in the unit square, folded onto its lower triangle
    corner = jnp.where(half.sum() > 1, 1 - half, half)
    unit = jnp.where(cells.is_triangle[cell], unit.at[:2].set(corner), unit)
    return cells.origin[cell] + unit @ cells.axes[cell], cells.part[cell]


def _cells(region: Region) -> list[_Cell]:
    """What a region without parts consists of."""
    if region.kind in SHAPES:
        return [_shape_cell(region)]
    found = []
    for a, b, c in triangles(region.points):
        origin, axes = np.array(region.center), np.zeros((region.dimension,) * 2)
        origin[:2], axes[0, :2], axes[1, :2] = a, b - a, c - a
        if region.dimension == 3:
            axes[2, 2] = region.size[2]
        volume = abs(np.linalg.det(axes)) / 2 * 2 ** (region.dimension - 2)
        found.append(_Cell(origin, axes, np.zeros(region.dimension), True, volume))
    return found


def _shape_cell(region: Region) -> _Cell:
    """A box, a ball or a cylinder, turned by its angle."""
    size, is_round = np.array(region.size), round_axes(region)
    half = size[[0, 0, 1]] if region.kind == "cylinder" else np.resize(size, region.dimension)
    axes = np.diag(half)
    cosine, sine = region.turn
    axes[:, :2] = axes[:, :2] @ np.array([[cosine, sine], [-sine, cosine]])
    ball = {0: 1.0, 2: np.pi, 3: 4 / 3 * np.pi}[int(is_round.sum())]
    volume = float(np.prod(half)) * ball * 2 ** (region.dimension - int(is_round.sum()))
    return _Cell(np.array(region.center), axes, is_round, False, volume)


def _middle(cell: _Cell) -> np.ndarray:
    """The centroid [d] of a cell [m]."""
    unit = np.zeros(len(cell.origin))
    unit[:2] = 1 / 3 if cell.is_triangle else 0.0
    return cell.origin + unit @ cell.axes
