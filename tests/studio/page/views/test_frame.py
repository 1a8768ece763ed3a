import numpy as np
import pytest

from scenes import Region
from studio.page.views.frame import drop


@pytest.mark.parametrize("kind", ["box", "sphere", "cylinder"])
def test_what_floats_drops_its_footprint_to_the_ground(kind):
    size = {"box": (0.5, 0.2, 0.3), "sphere": (0.3,), "cylinder": (0.5, 0.3)}[kind]
    segments = drop(Region("A", kind, (1.0, 2.0, 3.0), size), 0.1)
    np.testing.assert_allclose(segments[-1], [[1.0, 2.0, 2.7], [1.0, 2.0, 0.1]])
    points = segments[:-1].reshape(-1, 3)
    assert (points[:, 2] == 0.1).all()
    np.testing.assert_allclose(np.ptp(points, axis=0)[0], 2 * size[0])


def test_what_stands_on_the_ground_drops_nothing():
    assert len(drop(Region("A", "cylinder", (1.0, 2.0, 0.5), (0.3, 0.5)), 0.0)) == 0
