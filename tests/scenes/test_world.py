"""Worlds are made of the robots' workspaces."""

import numpy as np
import pytest

from envs import ENVS, Workspace
from scenes import load_task, make_world, world_of
from scenes.fields import Grid
from scenes.world import GridWorld

PLANAR = GridWorld(Grid((-5.0, -5.0), 0.125, (81, 81)), clearance=0.15, inset=0.1)
WORLDS = {
    "linear": PLANAR,
    "unicycle": PLANAR,
    "panda": GridWorld(Grid((0.1, -0.7, 0.0), 0.04, (20, 36, 26)), clearance=0.03, inset=0.02),
    "quadrotor": GridWorld(Grid((-5.0, -5.0, 0.0), 0.3125, (33, 33, 17)), 0.35, 0.15),
    "ant": GridWorld(Grid((-3.0, -3.0), 0.1, (61, 61)), clearance=0.2, inset=0.15),
}
"""Nodes on which the shipped policies were learnt."""


@pytest.mark.parametrize("robot", WORLDS)
def test_worlds_of_the_shipped_robots(robot):
    assert world_of(load_task(f"{robot}-demo")) == WORLDS[robot]


@pytest.mark.parametrize("robot", ENVS)
def test_fields_cover_the_workspace(robot):
    """To less than a cell beyond it."""
    workspace = ENVS[robot].workspace
    grid, limits = make_world(workspace).grid, np.array(workspace.arena)
    high = grid.nodes().max(0)
    np.testing.assert_allclose(grid.origin, limits[:, 0], atol=1e-9)
    assert (high >= limits[:, 1] - 1e-9).all()
    assert (high < limits[:, 1] + grid.spacing).all()


def test_an_arena_that_is_no_multiple_of_the_spacing_is_covered():
    grid = make_world(Workspace(((0.0, 1.0), (-1.0, 1.0)), spacing=0.3)).grid
    assert grid.shape == (5, 8)
    assert (grid.nodes().max(0) >= 1.0).all()
