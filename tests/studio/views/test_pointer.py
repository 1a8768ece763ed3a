import numpy as np
import pytest

from studio.views.pointer import level_point


def test_the_point_on_the_plane_is_on_the_ray():
    eye, through = np.array([0.0, -10.0, 10.0]), np.array([1.0, -5.0, 6.0])
    point = np.array(level_point(eye, through, 0.5))
    assert point[2] == 0.5
    assert np.cross(point - eye, through - eye) == pytest.approx(np.zeros(3))


@pytest.mark.parametrize("through", [(1.0, 2.0, 10.0), (1.0, 2.0, 12.0)])
def test_a_ray_that_does_not_meet_the_plane_ends_at_its_point(through):
    assert level_point(np.array([0.0, 0.0, 10.0]), np.array(through), 0.0) == (1.0, 2.0, 0.0)
