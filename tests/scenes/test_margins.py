import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scenes import Region, SceneError, margins, margins_and_gradients, region_arrays
from scenes.margins import PADDING_MARGIN
from tests.scenes.geometry import margin

PLANAR = (
    Region("A", "circle", (0.5, -1.0), (0.7,)),
    Region("B", "rectangle", (-1.0, 0.3), (1.5, 0.4)),
)
SPATIAL = (
    Region("A", "sphere", (0.5, -1.0, 0.2), (0.7,)),
    Region("B", "box", (-1.0, 0.3, 0.0), (1.5, 0.4, 0.9)),
    Region("C", "cylinder", (0.4, 0.3, -0.5), (0.8, 1.1)),
)
CAPACITY = 5
BATCH = jax.jit(jax.vmap(margins_and_gradients, (None, 0)))
BATCH_AUTOMATIC = jax.jit(jax.vmap(jax.jacrev(margins, 1), (None, 0)))
SCENES = pytest.mark.parametrize("regions", [PLANAR, SPATIAL], ids=["planar", "spatial"])


def _points(regions, count=400):
    dimension = regions[0].dimension
    return np.random.default_rng(3).uniform(-3, 3, (count, dimension)).astype(np.float32)


def _reference(regions, point):
    return np.array([margin(region, point) for region in regions])


@SCENES
def test_margins_equal_the_plain_geometry(regions):
    arrays = region_arrays(regions, regions[0].dimension, CAPACITY)
    points = _points(regions)
    values, _ = BATCH(arrays, points)
    expected = np.stack([_reference(regions, point) for point in points])
    np.testing.assert_allclose(values[:, : len(regions)], expected, atol=2e-6)
    assert (expected > 0).any(0).all() and (expected < 0).any(0).all()
    np.testing.assert_array_equal(values[:, len(regions) :], PADDING_MARGIN)


@SCENES
def test_gradients_equal_finite_differences_away_from_kinks(regions):
    arrays = region_arrays(regions, regions[0].dimension, CAPACITY)
    points = _points(regions)
    _, gradients = BATCH(arrays, points)
    smooth = 0
    for point, gradient in zip(points.astype(float), np.asarray(gradients), strict=True):
        steps = 1e-5 * np.eye(len(point))
        forward = np.stack([_reference(regions, point + step) for step in steps], -1)
        backward = np.stack([_reference(regions, point - step) for step in steps], -1)
        difference = (forward - backward) / 2e-5
        away = np.abs(np.linalg.norm(difference, axis=-1) - 1) < 1e-6
        smooth += away.sum()
        np.testing.assert_allclose(gradient[: len(regions)][away], difference[away], atol=1e-4)
        np.testing.assert_array_equal(gradient[len(regions) :], 0.0)
    assert smooth > 0.97 * len(points) * len(regions)


@SCENES
def test_automatic_differentiation_agrees_with_the_analytic_gradients(regions):
    arrays = region_arrays(regions, regions[0].dimension, CAPACITY)
    points = _points(regions)
    _, gradients = BATCH(arrays, points)
    automatic = BATCH_AUTOMATIC(arrays, points)
    np.testing.assert_allclose(automatic, gradients, atol=1e-5)


@SCENES
def test_gradients_stay_finite_at_centers(regions):
    arrays = region_arrays(regions, regions[0].dimension, CAPACITY)
    centers = np.zeros_like(_points(regions))
    centers[: len(regions)] = [region.center for region in regions]
    assert np.isfinite(BATCH(arrays, centers)[1]).all()
    assert np.isfinite(BATCH_AUTOMATIC(arrays, centers)).all()


@SCENES
def test_margins_vanish_on_the_boundary(regions):
    arrays = region_arrays(regions, regions[0].dimension, CAPACITY)
    edges = np.zeros_like(_points(regions))
    for row, region in enumerate(regions):
        edges[row] = region.center
        edges[row, 0] += region.size[0]
    values = np.diagonal(BATCH(arrays, edges)[0])[: len(regions)]
    np.testing.assert_allclose(values, 0.0, atol=1e-6)


def test_other_regions_compile_nothing():
    count = 0

    @jax.jit
    def traced(arrays, position):
        nonlocal count
        count += 1
        return margins(arrays, position)

    position = jnp.zeros(2)
    traced(region_arrays(PLANAR, 2, CAPACITY), position)
    traced(region_arrays(PLANAR[:1], 2, CAPACITY), position)
    traced(region_arrays((), 2, CAPACITY), position)
    assert count == 1


def test_too_many_regions_are_refused():
    with pytest.raises(SceneError, match="2 regions are too many: at most 1"):
        region_arrays(PLANAR, 2, 1)


def test_regions_of_another_dimension_are_refused():
    with pytest.raises(SceneError, match="'A' is a sphere of dimension 3; .* dimension 2"):
        region_arrays(SPATIAL, 2, CAPACITY)
