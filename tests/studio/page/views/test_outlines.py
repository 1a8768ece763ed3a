import jax.numpy as jnp
import numpy as np
import pytest

from scenes import Region
from scenes.distances import margin_of
from scenes.margins import margins, region_arrays
from studio.page.views.outlines import outline
from tests.scenes.outlines import planar, spatial

REGIONS = [
    Region("A", "rectangle", (1.0, 2.0), (0.5, 1.5)),
    Region("A", "circle", (1.0, 2.0), (0.5,)),
    Region("A", "box", (1.0, 2.0, 0.5), (0.5, 1.0, 0.3)),
    Region("A", "sphere", (1.0, 2.0, 0.5), (0.5,)),
    Region("A", "cylinder", (1.0, 2.0, 0.5), (0.5, 0.3)),
]
EDGES = {"rectangle": 4, "circle": 64, "box": 12, "sphere": 192, "cylinder": 128}


@pytest.mark.parametrize("region", REGIONS, ids=lambda region: region.kind)
def test_an_outline_lies_on_the_boundary(region):
    segments = outline(region, 0.1)
    assert segments.shape == (EDGES[region.kind], 2, 3)
    arrays = region_arrays((region,), region.dimension, 1)
    for point in segments.reshape(-1, 3)[::7]:
        if region.dimension == 2:
            assert point[2] == pytest.approx(0.1)
        margin = margins(arrays, jnp.asarray(point[: region.dimension]))
        assert float(margin[0]) == pytest.approx(0.0, abs=1e-5)


@pytest.mark.parametrize("dimension", [2, 3])
def test_outlines_of_other_kinds_lie_on_the_boundary_of_a_part(dimension):
    regions = planar(np.random.default_rng(0))
    for flat in regions:
        region = flat if dimension == 2 else spatial(flat, 0.5, 2.0)
        points = outline(region, 0.1).reshape(-1, 3)[:, :dimension]
        parts = np.min([np.abs(margin_of(part, points)) for part in region.pieces], axis=0)
        np.testing.assert_allclose(parts, 0.0, atol=1e-6)
        np.testing.assert_allclose(points.min(0), region.center - region.half_extents, atol=0.01)
        np.testing.assert_allclose(points.max(0), region.center + region.half_extents, atol=0.01)


def test_planar_outlines_exactly():
    circle = outline(Region("A", "circle", (1.0, 2.0), (0.5,)), 0.1).reshape(-1, 3)
    np.testing.assert_allclose(np.hypot(*(circle[:, :2] - (1, 2)).T), 0.5)
    corners = outline(Region("B", "rectangle", (1.0, 2.0), (0.5, 0.25)), 0.1).reshape(-1, 3)
    assert {tuple(c) for c in corners} == {(x, y, 0.1) for x in (0.5, 1.5) for y in (1.75, 2.25)}
