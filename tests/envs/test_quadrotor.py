import math
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from envs import Quadrotor
from envs.quadrotor import down_axis
from tests.envs.reference import quadrotor_fly, rotation

DRONE = Quadrotor()
RAW = Quadrotor(raw_motors=True)
HOVER = DRONE.hover_force


def _state(**parts) -> jax.Array:
    names = ("x", "y", "z", "vx", "vy", "vz", "phi", "theta", "psi", "wx", "wy", "wz")
    return jnp.array([parts.get(name, 0.0) for name in names], jnp.float32)


def _fly(state, actions, robot=DRONE):
    """States after each of the actions [T, 4]; padded so that one length is compiled."""
    padded = np.zeros((100, 4), np.float32)
    padded[: len(actions)] = actions
    return np.asarray(_states(robot, state, padded))[: len(actions)]


@partial(jax.jit, static_argnums=0)
def _states(robot, state, actions):
    def advance(carry, action):
        following = robot.step(carry, action)
        return following, following

    return jax.lax.scan(advance, state, actions)[1]


@pytest.mark.parametrize("robot", [DRONE, RAW], ids=["attitude", "raw"])
def test_hover_is_an_equilibrium(robot):
    start = _state(x=1.0, z=-2.0, psi=0.7)
    np.testing.assert_allclose(robot.motor_forces(start, jnp.zeros(4)), [HOVER] * 4, rtol=1e-6)
    end = _fly(start, np.zeros((100, 4)), robot)[-1]
    np.testing.assert_allclose(end, start, atol=2e-4)  # float32: weight against thrust, 100 steps


def test_without_thrust_it_falls_freely():
    """p_k = p_0 + v_0 k dt + g dt^2 k (k - 1) / 2, explicit Euler's parabola."""
    state = _state(x=1.0, z=-20.0, vx=2.0, vz=-1.0, psi=1.0)
    energies = []
    for step in range(1, 21):
        state = DRONE.fly(state, jnp.zeros(4))
        fallen = -20.0 - 0.1 * step + 9.81 * 0.01 * step * (step - 1) / 2
        np.testing.assert_allclose(state[:3], [1.0 + 0.2 * step, 0.0, fallen], atol=1e-4)
        energies.append(float(0.5 * (state[3:6] ** 2).sum() - 9.81 * state[2]))
    # Euler's energy grows by (g dt)^2 / 2 a step, exactly
    np.testing.assert_allclose(np.diff(energies), (9.81 * 0.1) ** 2 / 2, rtol=1e-2)


def test_raw_motors_follow_the_equations_in_float64():
    generator = np.random.default_rng(3)
    for _ in range(30):
        state = generator.normal(size=12) * [5] * 12
        state[6:9] = generator.uniform(-3, 3, 3)
        action = generator.uniform(-1.5, 1.5, 4)
        forces = HOVER * (1 + 0.5 * np.clip(action, -1, 1))
        found = RAW.step(jnp.asarray(state, jnp.float32), jnp.asarray(action, jnp.float32))
        np.testing.assert_allclose(found, quadrotor_fly(state, forces), rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize(
    ("angles", "down"),
    [
        ((0, 0, 0), (0, 0, 1)),
        ((math.pi / 2, 0, 0), (0, -1, 0)),  # rolled to the right: thrust pulls to the right, +y
        ((0, math.pi / 2, 0), (1, 0, 0)),  # nose up: thrust pulls backwards, -x
        ((0, math.pi / 2, math.pi / 2), (0, 1, 0)),
        ((math.pi, 0, 0.3), (0, 0, -1)),
    ],
)
def test_attitudes_mean_what_the_paper_says(angles, down):
    state = _state(phi=angles[0], theta=angles[1], psi=angles[2])
    np.testing.assert_allclose(down_axis(state), down, atol=1e-6)
    np.testing.assert_allclose(rotation(*angles)[:, 2], down, atol=1e-12)


@pytest.mark.parametrize(("motor", "angle", "sign"), [(0, 7, 1), (2, 7, -1), (1, 6, -1), (3, 6, 1)])
def test_a_stronger_motor_lifts_its_side(motor, angle, sign):
    """Front lifts the nose (theta > 0), left rolls to the right (phi > 0)."""
    forces = jnp.full(4, HOVER).at[motor].add(0.1)
    state = DRONE.fly(DRONE.fly(_state(), forces), forces)
    assert sign * state[angle] > 1e-3
    others = [6, 7]
    others.remove(angle)
    assert abs(state[others[0]]) < 1e-6


@pytest.mark.parametrize(
    ("action", "entry", "value"), [((0, 1, 0, 0), 6, 0.6), ((0, 0, -1, 0), 7, -0.6)]
)
def test_the_inner_loop_reaches_the_tilt_that_is_asked_for(action, entry, value):
    states = _fly(_state(psi=0.4), np.tile(action, (25, 1)))
    np.testing.assert_allclose(states[-1, entry], value, atol=1e-2)
    assert np.abs(states[:, entry]).max() < 0.65  # hardly any overshoot


def test_the_inner_loop_keeps_the_yaw_rate():
    states = _fly(_state(), np.tile([0, 0, 0, 1.0], (25, 1)))
    np.testing.assert_allclose(states[-1, 11], 1.0, atol=1e-3)


def test_forces_stay_within_the_motors_limits():
    generator = np.random.default_rng(0)
    states = jnp.asarray(generator.normal(size=(200, 12)) * 3, jnp.float32)
    actions = jnp.asarray(generator.uniform(-2, 2, (200, 4)), jnp.float32)
    forces = jax.vmap(DRONE.motor_forces)(states, actions)
    assert (forces >= 0).all() and (forces <= DRONE.max_force).all()
    assert (forces == 0).any() and (forces == DRONE.max_force).any()


def test_climbing_is_up_in_the_scene():
    states = _fly(_state(z=-1.0), np.tile([1.0, 0, 0, 0], (10, 1)))
    heights = np.asarray(DRONE.position(jnp.asarray(states)))[:, 2]
    assert (np.diff(heights) > 0).all() and heights[-1] > 3.0
    assert DRONE.velocity(jnp.asarray(states))[-1, 2] > 0


def test_the_scenes_frame_is_right_handed():
    turned = [DRONE.position(_state(x=a, y=b, z=c)) for a, b, c in np.eye(3)]
    assert np.linalg.det(np.stack(turned)) == pytest.approx(1.0)


@pytest.mark.parametrize("heading", [0.0, 0.9, -2.5])
def test_pitching_down_flies_forward_in_its_own_frame(heading):
    """Negative pitch accelerates forward, positive roll to the right, whatever the heading."""
    states = _fly(_state(psi=heading), np.tile([0, 0, -1.0, 0], (8, 1)))
    moved = DRONE.to_frame(_state(psi=heading), DRONE.position(jnp.asarray(states[-1])))
    assert moved[0] > 0.4 and abs(float(moved[1])) < 1e-3
    states = _fly(_state(psi=heading), np.tile([0, 1.0, 0, 0], (8, 1)))
    moved = DRONE.to_frame(_state(psi=heading), DRONE.position(jnp.asarray(states[-1])))
    assert moved[1] < -0.4 and abs(float(moved[0])) < 1e-3


def test_observations_are_free_of_position_and_heading_and_bounded():
    low, high = _state(vx=1.0, theta=0.2), _state(x=3.0, z=-2.0, vx=0.0, vy=1.0, theta=0.2)
    turned = high.at[8].set(math.pi / 2)
    np.testing.assert_allclose(DRONE.observe(low), DRONE.observe(turned), atol=1e-6)
    assert np.abs(DRONE.observe(_state(vx=1e6, wx=-1e6))).max() <= 4.0


def test_placed_robots_fly_in_all_directions():
    keys = jax.random.split(jax.random.key(0), 2000)
    states = jax.vmap(DRONE.place, (0, None))(keys, jnp.array([1.0, 2.0, 3.0]))
    speed = np.linalg.norm(states[:, 3:6], axis=1)
    assert speed.max() <= DRONE.placed_speed and speed.max() > 0.9 * DRONE.placed_speed
    assert np.abs(np.asarray(states[:, 3:6]).mean(0)).max() < 0.1
