"""The ant: its symmetry, its gait in true physics, and the fast model held against the truth."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.task.physics import physics_of
from envs.ant import Ant
from envs.ant.gait import KNEE_SIGN, motor_order, observe, shipped_gait
from envs.ant.model import DT, POSITIONS, STANDING, STATE, ant_model, has_fallen
from envs.ant.native import NativePhysics

ANT = Ant()


@pytest.fixture(scope="module")
def native() -> NativePhysics:
    return NativePhysics(shipped_gait(), ANT.reach)


def _directions(random: np.random.Generator, count: int) -> np.ndarray:
    angle = random.uniform(-np.pi, np.pi, count)
    return np.stack([np.cos(angle), np.sin(angle)], -1)


def _standing(random: np.random.Generator, count: int) -> np.ndarray:
    """States [N, 29] at rest at the origin, headings uniform."""
    states = np.tile(STANDING, (count, 1))
    half = random.uniform(-np.pi, np.pi, count) / 2
    states[:, 3], states[:, 6] = np.cos(half), np.sin(half)
    return states


def _walking(native, random: np.random.Generator, count: int) -> np.ndarray:
    """States [N, 29] half a second after setting out: every entry is in use."""
    states, ahead = _standing(random, count), _directions(random, count)
    for _ in range(10):
        states = native.step(states, ahead)
    return states


def _named_anew(states: np.ndarray) -> np.ndarray:
    """The same bodies [N, 29] with the torso's x axis taken a quarter turn further to the left.

    Leg 1 is then the leg that was leg 2, and so on; the world sees no difference.
    """
    w, x, y, z = states[:, 3:7].T
    half = np.sqrt(0.5)
    quaternion = half * np.stack([w - z, x + y, y - x, w + z], -1)
    spin = states[:, 18:21] @ np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    parts = [states[:, :3], quaternion, _legs_anew(states[:, 7:POSITIONS])]
    return np.concatenate([*parts, states[:, 15:18], spin, _legs_anew(states[:, 21:])], -1)


def _legs_anew(joints: np.ndarray) -> np.ndarray:
    """Joint values [N, 8] = (hip, ankle) of legs 1 to 4, each from the leg to its left."""
    hips, knees = joints[:, 0::2], joints[:, 1::2] * KNEE_SIGN
    turned = np.stack([np.roll(hips, -1, 1), np.roll(knees, -1, 1) * KNEE_SIGN], -1)
    return turned.reshape(-1, 8)


def _by_joint(torques: np.ndarray) -> np.ndarray:
    """Torques [N, 8] in the order of the joints from the order of the motors."""
    return torques[:, [2, 3, 4, 5, 6, 7, 0, 1]]


def test_motors_drive_the_joints_that_the_gait_names():
    model = ant_model()
    unit = motor_order(np.eye(8), np.zeros(8, int))
    for action, torques in enumerate(unit):
        (motor,) = np.flatnonzero(torques)
        joint = model.joint(model.actuator_trnid[motor, 0]).name
        assert joint == f"{'hip' if action < 4 else 'ankle'}_{action % 4 + 1}"


def test_the_gait_does_not_see_which_leg_is_called_the_first(native):
    random = np.random.default_rng(1)
    states, waypoints = _walking(native, random, 64), _directions(random, 64)
    seen, turns = observe(states, waypoints)
    seen_anew, turns_anew = observe(_named_anew(states), waypoints)
    np.testing.assert_array_equal(turns_anew, (turns - 1) % 4)
    np.testing.assert_allclose(seen_anew, seen, atol=1e-7)
    torques = shipped_gait().torques(states, waypoints)
    anew = shipped_gait().torques(_named_anew(states), waypoints)
    np.testing.assert_allclose(_by_joint(anew), _legs_anew(_by_joint(torques)), atol=1e-6)


def test_the_body_does_not_either(native):
    random = np.random.default_rng(2)
    states, waypoints = _walking(native, random, 64), _directions(random, 64)
    then = native.step(states, waypoints)
    then_anew = native.step(_named_anew(states), waypoints)
    np.testing.assert_allclose(then_anew[:, :3], then[:, :3], atol=1e-4)


@pytest.mark.parametrize("quarter", [1, 2, 3])
def test_a_turned_waypoint_turns_the_actions(quarter):
    states = np.tile(STANDING, (8, 1))
    waypoints = _directions(np.random.default_rng(3), 8)
    cosine, sine = [(0, 1), (-1, 0), (0, -1)][quarter - 1]
    turned = waypoints @ np.array([[cosine, sine], [-sine, cosine]])
    seen, turns = observe(states, waypoints)
    seen_turned, turns_turned = observe(states, turned)
    np.testing.assert_array_equal(turns_turned, (turns + quarter) % 4)
    np.testing.assert_allclose(seen_turned, seen, atol=1e-7)


def test_the_gait_is_the_same_in_jax(native):
    random = np.random.default_rng(4)
    states, waypoints = _walking(native, random, 64), _directions(random, 64)
    expected = shipped_gait().torques(states, waypoints)
    found = shipped_gait().torques(jnp.float32(states), jnp.float32(waypoints), jnp)
    np.testing.assert_allclose(found, expected, atol=2e-4)


def test_a_goal_three_metres_away_is_reached_in_five_seconds(native):
    random = np.random.default_rng(5)
    states, goal = _standing(random, 128), 3.0 * _directions(random, 128)
    arrived, fallen = np.zeros(128, bool), np.zeros(128, bool)
    for _ in range(round(5.0 / DT)):
        states = native.step(states, goal - states[:, :2])
        fallen |= has_fallen(states)
        arrived |= ~fallen & (np.linalg.norm(goal - states[:, :2], axis=1) < 0.5)
    assert arrived.mean() >= 0.98
    assert fallen.mean() <= 0.02


def test_a_waypoint_underfoot_means_standing(native):
    states = _standing(np.random.default_rng(6), 32)
    for _ in range(round(10.0 / DT)):
        states = native.step(states, np.zeros((32, 2)))
    assert not has_fallen(states).any()
    assert np.linalg.norm(states[:, :2], axis=1).max() < 0.5


def test_a_lost_row_stays_alone(native):
    random = np.random.default_rng(7)
    states, actions = _walking(native, random, 8), _directions(random, 8)
    whole = native.step(states, actions)
    broken = states.copy()
    broken[2, 20], broken[5, 0] = np.nan, np.inf
    mended = native.step(broken, actions)
    assert np.isnan(mended[[2, 5]]).all()
    others = [0, 1, 3, 4, 6, 7]
    np.testing.assert_array_equal(mended[others], whole[others])
    assert has_fallen(mended)[[2, 5]].all()


def test_a_simulation_that_diverges_is_not_put_back_at_the_origin(native, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warning to a file there
    states = np.tile(STANDING, (2, 1))
    states[:, :2] = 3.0
    states[0, 0] = 1e11  # beyond what MuJoCo takes for a number
    after = native.torque_step(states, np.zeros((2, 8)))
    assert np.isnan(after[0]).all()
    assert np.isfinite(after[1]).all()


def test_a_batch_of_none_and_of_one(native):
    assert native.step(np.zeros((0, STATE)), np.zeros((0, 2))).shape == (0, STATE)
    assert native.step(STANDING[None], np.ones((1, 2))).shape == (1, STATE)


def test_it_rests_on_its_feet_and_is_placed_in_motion():
    position = jnp.array([1.0, -2.0])
    keys = jax.random.split(jax.random.key(0), 64)
    rest = np.asarray(jax.vmap(lambda key: ANT.rest(key, position))(keys))
    placed = np.asarray(jax.vmap(lambda key: ANT.place(key, position))(keys))
    for states in (rest, placed):
        np.testing.assert_allclose(states[:, :2], np.tile(position, (64, 1)))
        np.testing.assert_allclose(np.linalg.norm(states[:, 3:7], axis=1), 1, atol=1e-6)
        assert not has_fallen(states).any()
    assert not rest[:, POSITIONS:].any()
    speeds = np.linalg.norm(placed[:, 15:17], axis=1)
    assert speeds.max() <= ANT.placed_speed
    assert speeds.std() > 0.1


def test_the_truth_is_native_on_a_cpu():
    if jax.default_backend() == "cpu":
        assert isinstance(physics_of(ANT), NativePhysics)


def test_the_fast_model_is_close_to_the_truth(native):
    """Two seconds of waypoints 0.2 to 0.7 m away that change every half a second."""
    random = np.random.default_rng(8)
    truth, count = _standing(random, 128), 128
    fast = jnp.float32(truth)
    step = jax.jit(jax.vmap(ANT.step))
    for time in range(40):
        if time % 10 == 0:
            distance = random.uniform(0.2, 0.7, (count, 1))
            actions = distance / ANT.reach * _directions(random, count)
        truth, fast = native.step(truth, actions), step(fast, jnp.float32(actions))
    error = np.linalg.norm(truth[:, :2] - np.asarray(fast)[:, :2], axis=1)
    assert np.median(error) < 0.4
    assert np.quantile(error, 0.9) < 0.75
