"""Margins of turned shapes, polygons, prisms and unions, against shapely on random ones."""

import jax
import numpy as np
import pytest

from scenes import Region, margins, margins_and_gradients, region_arrays
from scenes.compound import PADDING_MARGIN
from scenes.distances import margin_of
from tests.scenes.outlines import depth, planar, spatial

CAPACITY = 12
BATCH = jax.jit(jax.vmap(margins_and_gradients, (None, 0)))
BATCH_AUTOMATIC = jax.jit(jax.vmap(jax.jacrev(margins, 1), (None, 0)))
SEEDS = pytest.mark.parametrize("seed", range(3))


def _scene(seed: int, dimension: int) -> tuple[list[Region], np.ndarray]:
    """Regions of all kinds and positions [P, d] around them."""
    random = np.random.default_rng(seed)
    regions = planar(random)
    if dimension == 3:
        ends = [sorted(random.uniform(-2, 2, 2)) for _ in regions]
        regions = [spatial(r, *end) for r, end in zip(regions, ends, strict=True)]
    near = [r.center + r.half_extents * random.uniform(-1, 1, (20, dimension)) for r in regions]
    positions = np.concatenate([*near, random.uniform(-4, 4, (100, dimension))])
    return regions, positions.astype(np.float32)


def _reference(region: Region, positions: np.ndarray) -> np.ndarray:
    """Margins [P]; the depth in a union as the largest of its parts'."""
    if region.kind == "union":
        return np.max([_reference(part, positions) for part in region.parts], axis=0)
    margin = depth(region, positions[:, :2])
    if region.dimension == 2:
        return margin
    ends = region.center[2] - region.half_extents[2], region.center[2] + region.half_extents[2]
    inner = np.minimum(positions[:, 2] - ends[0], ends[1] - positions[:, 2])
    outside = np.hypot(np.minimum(margin, 0), np.minimum(inner, 0))
    return np.where(outside > 0, -outside, np.minimum(margin, inner))


@SEEDS
@pytest.mark.parametrize("dimension", [2, 3])
def test_margins_are_the_signed_distances(seed, dimension):
    regions, positions = _scene(seed, dimension)
    values, _ = BATCH(region_arrays(tuple(regions), dimension, CAPACITY), positions)
    expected = np.stack([_reference(r, positions.astype(float)) for r in regions], -1)
    np.testing.assert_allclose(values[:, : len(regions)], expected, atol=5e-6)
    assert (expected > 0).any(0).all() and (expected < 0).any(0).all()
    np.testing.assert_array_equal(values[:, len(regions) :], PADDING_MARGIN)
    for region, column in zip(regions, expected.T, strict=True):
        np.testing.assert_allclose(margin_of(region, positions.astype(float)), column, atol=1e-6)


@SEEDS
def test_unions_are_entered_where_any_part_is(seed):
    """Outside, the margin is the distance from the union itself; inside, at most the depth."""
    regions, positions = _scene(seed, 2)
    union = regions[-1]
    margin, exact = margin_of(union, positions.astype(float)), depth(union, positions)
    outside = exact < 0
    np.testing.assert_allclose(margin[outside], exact[outside], atol=1e-6)
    assert (margin[~outside] >= 0).all() and (margin <= exact + 1e-6).all()


@SEEDS
@pytest.mark.parametrize("dimension", [2, 3])
def test_gradients_are_those_of_the_margins(seed, dimension):
    """Unit vectors, as differentiation gives them, and as finite differences away from kinks."""
    regions, positions = _scene(seed, dimension)
    arrays = region_arrays(tuple(regions), dimension, CAPACITY)
    values, gradients = BATCH(arrays, positions)
    away = np.abs(values) > 0.02  # closer, float32 says little of a difference of positions
    automatic = BATCH_AUTOMATIC(arrays, positions)
    np.testing.assert_allclose(automatic[away], gradients[away], atol=2e-4)
    np.testing.assert_array_equal(gradients[:, len(regions) :], 0.0)
    exact, steps = positions.astype(float), 1e-6 * np.eye(dimension)
    smooth = 0
    for number, region in enumerate(regions):
        ahead = np.stack([margin_of(region, exact + step) for step in steps], -1)
        behind = np.stack([margin_of(region, exact - step) for step in steps], -1)
        slope = (ahead - behind) / 2e-6
        away = np.abs(np.linalg.norm(slope, axis=1) - 1) < 1e-5
        smooth += away.sum()
        np.testing.assert_allclose(gradients[away, number], slope[away], atol=2e-3)
    assert smooth > 0.97 * len(regions) * len(positions)


def test_gradients_stay_finite_on_corners_and_edges():
    corners = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (1.0, 0.5))
    prism = Region("A", "prism", points=corners, z=(0.0, 1.0))
    arrays = region_arrays((prism,), 3, CAPACITY)
    edges = [(1.0, 0.0, z) for z in (0.0, 0.5, 1.0)]
    positions = np.array([(*corner, z) for corner in corners for z in (0, 0.5, 1)] + edges, "f4")
    values, gradients = BATCH(arrays, positions)
    np.testing.assert_allclose(values[:, 0], 0.0, atol=1e-6)
    assert np.isfinite(gradients).all()
    assert np.isfinite(BATCH_AUTOMATIC(arrays, positions)).all()
    np.testing.assert_allclose(gradients[-2, 0], (0.0, 1.0, 0.0), atol=1e-6)


def test_plain_scenes_do_without():
    plain = Region("A", "rectangle", (0.0, 0.0), (1.0, 1.0))
    assert region_arrays((plain,), 2, CAPACITY).compound is None
    turned = Region("A", "rectangle", (0.0, 0.0), (1.0, 1.0), angle=30.0)
    compound = region_arrays((plain, turned), 2, CAPACITY).compound
    assert compound is not None and compound.corners.size == 0


def test_other_regions_compile_nothing():
    count = 0

    @jax.jit
    def traced(arrays, position):
        nonlocal count
        count += 1
        return margins(arrays, position)

    for seed in range(3):
        regions, positions = _scene(seed, 2)
        traced(region_arrays(tuple(regions), 2, CAPACITY), positions[0])
    assert count == 1
