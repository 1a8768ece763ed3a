"""Margins in double precision are those that traces are judged by."""

import numpy as np
import pytest

from scenes import Region, margins, region_arrays
from scenes.distances import margin_of
from scenes.regions import SHAPES

SIZES = (0.7, 0.3, 0.5)


@pytest.mark.parametrize("kind", SHAPES)
def test_they_agree(kind):
    dimension, names = SHAPES[kind]
    region = Region("A", kind, (0.4, -0.2, 1.0)[:dimension], SIZES[: len(names)])
    positions = np.random.default_rng(0).uniform(-2, 2, (200, dimension))
    arrays = region_arrays((region,), dimension, 1)
    expected = [float(margins(arrays, position)[0]) for position in positions.astype(np.float32)]
    np.testing.assert_allclose(margin_of(region, positions), expected, atol=1e-5)
