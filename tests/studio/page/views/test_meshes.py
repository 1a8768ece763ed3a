"""Surfaces of regions: closed, seen from outside, around the volume that is theirs."""

import numpy as np
import pytest
import trimesh

from scenes.distances import margin_of
from studio.page.views.meshes import mesh_of
from tests.scenes.outlines import planar, shape, spatial

REGIONS = [r for seed in range(3) for r in planar(np.random.default_rng(seed))]


@pytest.mark.parametrize("region", REGIONS, ids=lambda region: region.kind)
def test_a_mesh_encloses_its_region(region):
    """Of a union, the parts' volumes add up: where they overlap, there are several surfaces."""
    expected = sum(shape(part).area for part in region.pieces)
    for each, height in ((region, 0.8), (spatial(region, 0.5, 1.3), 9.0)):
        mesh = trimesh.Trimesh(*mesh_of(each, height))
        assert mesh.is_watertight and mesh.is_winding_consistent
        assert mesh.volume == pytest.approx(0.8 * expected, rel=2e-3)
        np.testing.assert_allclose(mesh.bounds[1, 2], 0.4, atol=1e-6)
        np.testing.assert_allclose(mesh.bounds[0, 2], -0.4, atol=1e-6)
        middle = np.array([*each.center, 0.0][:3])
        on_surface = (mesh.triangles_center + middle)[:, : each.dimension]
        if each.dimension == 3:
            parts = np.min([np.abs(margin_of(p, on_surface)) for p in each.pieces], axis=0)
            assert parts.max() < 5e-3  # a circle has 64 corners
