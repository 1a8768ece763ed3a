"""Where a robot can be placed at all: an arm does not reach every corner of its arena."""

from functools import cache

import jax
import jax.numpy as jnp
import numpy as np

from envs import make_robot
from scenes.layouts import half_extents
from scenes.regions import Region
from scenes.world import make_world


def reaches(robot_name: str, region: Region) -> bool:
    """Whether a robot reaches the centre of a region and its extremes along the axes."""
    reached = _reached(robot_name)
    grid = make_world(make_robot(robot_name).workspace).grid
    center, half = np.array(region.center), half_extents(region)
    offsets = np.concatenate([np.zeros((1, half.size)), np.diag(half), -np.diag(half)])
    index = np.rint((center + offsets - np.array(grid.origin)) / grid.spacing).astype(int)
    inside = ((index >= 0) & (index < np.array(grid.shape))).all()
    return bool(inside and reached[tuple(index.T)].all())


@cache
def _reached(robot_name: str) -> np.ndarray:
    """[*shape] whether the robot, placed at a node of its grid, is there."""
    robot = make_robot(robot_name)
    world = make_world(robot.workspace)
    nodes = jnp.asarray(world.grid.nodes(), jnp.float32)
    keys = jax.random.split(jax.random.key(0), len(nodes))

    @jax.jit
    def distance(keys: jax.Array, nodes: jax.Array) -> jax.Array:
        position = jax.vmap(lambda key, node: robot.position(robot.place(key, node)))(keys, nodes)
        return jnp.linalg.norm(position - nodes, axis=-1)

    return np.asarray(distance(keys, nodes) <= world.clearance).reshape(world.grid.shape)
