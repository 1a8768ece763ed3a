import numpy as np
import pytest

from studio.page.views.pointer import axis_point, level_point


def test_the_point_on_the_plane_is_on_the_ray():
    eye, through = np.array([0.0, -10.0, 10.0]), np.array([1.0, -5.0, 6.0])
    point = np.array(level_point(eye, through, 0.5))
    assert point[2] == 0.5
    assert np.cross(point - eye, through - eye) == pytest.approx(np.zeros(3))


@pytest.mark.parametrize("through", [(1.0, 2.0, 10.0), (1.0, 2.0, 12.0)])
def test_a_ray_that_does_not_meet_the_plane_ends_at_its_point(through):
    assert level_point(np.array([0.0, 0.0, 10.0]), np.array(through), 0.0) == (1.0, 2.0, 0.0)


@pytest.mark.parametrize("axis", range(3))
def test_the_point_on_an_axis_is_the_nearest_to_the_ray(axis):
    eye, through = np.array([3.0, -10.0, 7.0]), np.array([1.5, -2.0, 2.5])
    origin = np.array([1.0, 0.5, 1.0])
    point = np.array(axis_point(eye, through, origin, axis))
    assert [i for i in range(3) if point[i] != origin[i]] == [axis]

    def distance(place):
        ray = (through - eye) / np.linalg.norm(through - eye)
        return np.linalg.norm(np.cross(place - eye, ray))

    for step in (-0.01, 0.01):
        assert distance(point) < distance(point + step * np.eye(3)[axis])


def test_a_ray_along_the_axis_moves_nothing():
    eye, through = np.array([1.0, 0.0, 9.0]), np.array([1.0, 0.0, 3.0])
    assert axis_point(eye, through, np.array([1.0, 0.1, 0.5]), 2) == (1.0, 0.1, 0.5)
