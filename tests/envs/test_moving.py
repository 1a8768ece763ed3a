"""Every robot can be put somewhere else, and keeps what its position does not decide."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.task.moving import move_robot
from envs import ENVS

AWAY = {
    "linear": (1.5, -2.0),
    "unicycle": (-1.0, 0.5),
    "panda": (0.1, 0.2, -0.15),
    "quadrotor": (1.0, -2.0, 0.5),
    "ant": (0.7, 1.1),
}


@pytest.mark.parametrize("name", ENVS)
def test_a_robot_is_moved(name):
    robot = ENVS[name]
    middle = jnp.asarray(robot.workspace.middle, jnp.float32)
    state = robot.place(jax.random.key(1), middle)
    target = robot.position(state) + jnp.asarray(AWAY[name], jnp.float32)
    after, reached = move_robot(state, target, robot=robot)
    np.testing.assert_allclose(reached, target, atol=2e-3)
    np.testing.assert_allclose(robot.position(after), reached, atol=1e-6)
    np.testing.assert_allclose(robot.observe(after)[:2], robot.observe(state)[:2], atol=0.5)
    if name != "panda":  # an arm moves all its joints
        changed = ~np.isclose(after, state, atol=1e-5)
        assert changed.sum() == robot.position_size


def test_an_arm_stays_within_its_limits():
    """A place out of reach: the arm stretches as far as its joints allow."""
    robot = ENVS["panda"]
    state = robot.rest(jax.random.key(0), jnp.array([0.5, 0.0, 0.5]))
    after, _ = move_robot(state, jnp.array([-3.0, 3.0, 3.0]), robot=robot)
    standing = robot.step(after, jnp.zeros(7))  # clips to the limits
    np.testing.assert_allclose(standing, after, atol=1e-6)
