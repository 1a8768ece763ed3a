"""Every robot has a world for its fields."""

import numpy as np
import pytest

from envs import ENVS
from studio.tasks import WORLDS


def test_every_robot_has_a_world():
    assert set(WORLDS) == set(ENVS)


@pytest.mark.parametrize("robot", ENVS)
def test_fields_cover_the_workspace(robot):
    """To less than a cell beyond it."""
    grid, limits = WORLDS[robot].grid, np.array(ENVS[robot].workspace)
    low, high = np.array(grid.origin), grid.nodes().max(0)
    assert grid.dimension == ENVS[robot].position_size
    np.testing.assert_allclose(low, limits[:, 0], atol=1e-9)
    assert (high >= limits[:, 1] - 1e-9).all()
    assert (high < limits[:, 1] + grid.spacing).all()
