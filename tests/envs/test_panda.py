import jax
import jax.numpy as jnp
import numpy as np
import pytest

from envs import Panda
from envs.panda import READY
from tests.envs.reference import PANDA_HIGH, PANDA_LOW, panda_tip

ARM = Panda()


def _postures(count: int) -> np.ndarray:
    return np.random.default_rng(5).uniform(PANDA_LOW, PANDA_HIGH, (count, 7))


def test_forward_kinematics_equal_the_product_of_exponentials():
    postures = _postures(200)
    expected = [panda_tip(posture) for posture in postures]
    with jax.enable_x64(True):
        found = ARM.position(jnp.asarray(postures))
    np.testing.assert_allclose(found, expected, atol=1e-12)
    single = ARM.position(jnp.asarray(postures, jnp.float32))
    np.testing.assert_allclose(single, expected, atol=1.5e-6)  # float32 at a metre


@pytest.mark.parametrize(("tool", "height"), [(0.0, 0.590282), (0.1034, 0.486882)])
def test_the_ready_posture_is_where_franka_says(tool, height):
    """The flange and the hand of the ready posture, as MoveIt's Panda tutorials print them."""
    tip = Panda(tool=tool).position(jnp.array(READY))
    np.testing.assert_allclose(tip, [0.306891, 0.0, height], atol=1e-6)


def test_the_jacobian_is_the_derivative():
    with jax.enable_x64(True):
        postures = jnp.asarray(_postures(20))
        expected = jax.vmap(jax.jacfwd(ARM.position))(postures)
        np.testing.assert_allclose(jax.vmap(ARM.jacobian)(postures), expected, atol=1e-12)


def test_joints_stop_at_their_limits():
    generator = np.random.default_rng(0)
    state = jnp.array(READY)
    direction = generator.choice([-1.0, 1.0], 7)
    step = jax.jit(ARM.step)
    for _ in range(100):
        state = step(state, jnp.asarray(direction, jnp.float32))
    limits = np.where(direction > 0, PANDA_HIGH, PANDA_LOW)
    np.testing.assert_allclose(state, limits, rtol=1e-6)


def test_no_joint_is_faster_than_its_limit():
    change = ARM.step(jnp.array(READY), jnp.full(7, 50.0)) - jnp.array(READY)
    np.testing.assert_allclose(change / 0.05, [2.175] * 4 + [2.61] * 3, rtol=1e-5)


def test_a_move_along_a_framed_vector_climbs_it():
    """J^T v is the gradient of v . p: the joints that follow it move the tip along v."""
    states = jnp.asarray(_postures(20) * 0.8, jnp.float32)
    for vector in jnp.eye(3):
        felt = jax.vmap(ARM.to_frame, (0, None))(states, vector)
        small = 1e-2 * felt
        gain = (ARM.position(states + small) - ARM.position(states)) @ vector
        np.testing.assert_allclose(
            gain, (small * felt).sum(-1) / ARM.frame_gain, rtol=0.1, atol=1e-5
        )


@pytest.mark.parametrize("start", ["rest", "place"])
def test_starts_have_the_end_effector_at_the_position(start):
    targets = np.random.default_rng(1).uniform([0.25, -0.5, 0.1], [0.65, 0.5, 0.7], (500, 3))
    keys = jax.random.split(jax.random.key(0), 500)
    states = jax.vmap(getattr(ARM, start))(keys, jnp.asarray(targets, jnp.float32))
    away = np.linalg.norm(ARM.position(states) - targets, axis=1)
    assert np.quantile(away, 0.99) < 1e-3, np.sort(away)[-10:]
    assert (states >= np.array(PANDA_LOW) - 1e-6).all()
    assert (states <= np.array(PANDA_HIGH) + 1e-6).all()


def test_placed_arms_differ_in_posture():
    keys = jax.random.split(jax.random.key(0), 200)
    position = jnp.array([0.5, 0.2, 0.4])
    spread = np.asarray(jax.vmap(ARM.place, (0, None))(keys, position)).std(0)
    calm = np.asarray(jax.vmap(ARM.rest, (0, None))(keys, position)).std(0)
    assert (spread > 0.1).all() and (calm < 0.1).all(), (spread, calm)


def test_out_of_reach_gives_a_finite_posture():
    state = ARM.place(jax.random.key(0), jnp.array([3.0, 0.0, 3.0]))
    assert np.isfinite(state).all()


def test_the_planning_speed_can_be_moved():
    """From the ready posture, along every axis of the workspace, joint velocities in limits."""
    state = jnp.array(READY)
    jacobian = np.asarray(ARM.jacobian(state))
    for axis in np.eye(3):
        velocity = np.linalg.pinv(jacobian) @ axis * ARM.speed / ARM.dt
        assert (np.abs(velocity) <= np.array(ARM.max_velocity)).all(), (axis, velocity)
