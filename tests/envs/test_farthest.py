"""No step of a robot exceeds the bound that it states; `linear` attains it."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.task.protocols import begins_exactly, farthest_of
from envs import ENVS, make_robot

STEPS, COUNT = 25, 64
BOUNDED = [
    (name, variant)
    for name in ("linear", "unicycle", "panda", "quadrotor")
    for variant in ("", *make_robot(name).variants)
]
ROUNDING = 2e-6  # [m] of float32 positions of up to 5 m


def positions(robot, actions):
    """Positions [STEPS + 1, N, d] of episodes that begin at rest."""
    middle = jnp.asarray(robot.workspace.middle, jnp.float32)
    keys = jax.random.split(jax.random.key(0), actions.shape[1])
    states = jax.vmap(robot.rest, (0, None))(keys, middle)

    def advance(state, action):
        after = jax.vmap(robot.step)(state, action)
        return after, after

    _, visited = jax.lax.scan(advance, states, actions)
    return np.asarray(jax.vmap(jax.vmap(robot.position))(jnp.concatenate([states[None], visited])))


def actions_of(robot):
    """Random signs held for a while: extreme, in every direction [STEPS, N, m]."""
    random = np.random.default_rng(1)
    held = random.choice([-1.0, 1.0, 1.0], (STEPS // 5, COUNT, robot.action_size))
    return jnp.asarray(np.repeat(held, 5, axis=0), jnp.float32)


@pytest.mark.parametrize(("name", "variant"), BOUNDED)
def test_no_step_exceeds_the_bound(name, variant):
    robot = make_robot(name, variant)
    visited = positions(robot, actions_of(robot))
    change = np.abs(np.diff(visited, axis=0))
    way = np.concatenate([change, np.linalg.norm(change, axis=-1, keepdims=True)], -1).max(1)
    bound = np.array([farthest_of(robot, step) for step in range(STEPS)])
    assert (way <= bound * (1 + 1e-5) + ROUNDING).all()
    assert (np.diff(bound, axis=0) >= 0).all()


def test_linear_attains_it():
    robot = ENVS["linear"]
    visited = positions(robot, jnp.ones((STEPS, 1, 2)))
    assert np.abs(visited[-1] - visited[0]).max() == pytest.approx(STEPS * farthest_of(robot, 0)[0])


def test_nothing_is_known_of_the_ants_speed():
    assert farthest_of(ENVS["ant"], 3) == (np.inf,) * 3


@pytest.mark.parametrize("name", ["linear", "unicycle", "quadrotor", "ant"])
def test_these_begin_exactly(name):
    robot = make_robot(name)
    assert begins_exactly(robot)
    places = jnp.full((8, robot.position_size), jnp.asarray(robot.workspace.middle) + 0.1)
    states = jax.vmap(robot.rest)(jax.random.split(jax.random.key(2), 8), places)
    assert np.array_equal(np.asarray(jax.vmap(robot.position)(states)), places)


def test_the_arm_is_not_known_to():
    assert not begins_exactly(ENVS["panda"])
