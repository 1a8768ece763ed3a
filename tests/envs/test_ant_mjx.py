"""MJX and native MuJoCo simulate the same ant. One compilation, most of a minute on a CPU."""

import jax.numpy as jnp
import numpy as np
import pytest

from envs.ant.gait import shipped_gait
from envs.ant.mjx import MjxPhysics, _closed_loop
from envs.ant.model import STANDING, has_fallen
from envs.ant.native import NativePhysics

COUNT = 16


@pytest.fixture(scope="module")
def simulators(disk_cache) -> tuple[NativePhysics, MjxPhysics]:
    return NativePhysics(shipped_gait(), 1.0), MjxPhysics(shipped_gait(), 1.0)


def _standing(random: np.random.Generator) -> np.ndarray:
    states = np.tile(STANDING, (COUNT, 1))
    half = random.uniform(-np.pi, np.pi, COUNT) / 2
    states[:, 3], states[:, 6] = np.cos(half), np.sin(half)
    return states


def test_the_same_torques_lead_along_the_same_path(simulators):
    """Ten physics steps; physics amplifies rounding, so that later only statistics agree."""
    native, mjx = simulators
    random = np.random.default_rng(1)
    one = other = _standing(random)
    for _ in range(2):
        torques = random.uniform(-1, 1, (COUNT, 8))
        one, other = native.torque_step(one, torques), mjx.torque_step(other, torques)
    np.testing.assert_allclose(other[:, :3], one[:, :3], atol=1e-5)


def test_the_gait_walks_as_far_in_both(simulators):
    """Three seconds in closed loop, waypoints 1 m ahead: mean distance within a tenth."""
    native, mjx = simulators
    random = np.random.default_rng(2)
    angle = random.uniform(-np.pi, np.pi, COUNT)
    ahead = np.stack([np.cos(angle), np.sin(angle)], -1)
    one = other = _standing(random)
    for _ in range(60):
        one = native.step(one, ahead)
        arguments = (jnp.float32(other), jnp.float32(ahead))
        other = np.asarray(_closed_loop(mjx._torque_step, shipped_gait(), 1.0, *arguments))
    walked = [(states[:, :2] * ahead).sum(1)[~has_fallen(states)] for states in (one, other)]
    assert min(len(distances) for distances in walked) >= COUNT - 2
    assert walked[1].mean() == pytest.approx(walked[0].mean(), rel=0.1)


def test_a_lost_row_stays_alone_in_mjx_too(simulators):
    _, mjx = simulators
    states, torques = _standing(np.random.default_rng(3)), np.zeros((COUNT, 8))
    whole = mjx.torque_step(states, torques)
    states[4, 17] = np.nan
    broken = mjx.torque_step(states, torques)
    assert np.isnan(broken[4]).all()
    np.testing.assert_array_equal(np.delete(broken, 4, 0), np.delete(whole, 4, 0))
