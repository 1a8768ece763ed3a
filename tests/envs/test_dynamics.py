import jax
import jax.numpy as jnp
import numpy as np
import pytest

from envs import ENVS, Linear, Unicycle
from tests.envs.reference import rollout

ROBOTS = pytest.mark.parametrize("name", ENVS)


@ROBOTS
def test_rollouts_equal_the_papers_equations_in_float64(name):
    robot = ENVS[name]
    generator = np.random.default_rng(11)
    initial = 0.5 * generator.normal(size=(8, robot.state_size)).astype(np.float32)
    actions = generator.uniform(-1.5, 1.5, (60, 8, robot.action_size)).astype(np.float32)
    assert (np.abs(actions) > 1).any()  # the clip is used

    def advance(state, action):
        following = jax.vmap(robot.step)(state, action)
        return following, following

    _, states = jax.jit(lambda s, a: jax.lax.scan(advance, s, a))(initial, actions)
    for lane in range(8):
        expected = rollout(name, initial[lane], actions[:, lane])[1:]
        # 60 float32 steps over some tens of metres: about 60 * 50 * 6e-8
        np.testing.assert_allclose(states[:, lane], expected, rtol=1e-5, atol=5e-4)


@ROBOTS
def test_rest_and_place_put_the_robot_at_the_position(name):
    robot = ENVS[name]
    position = jnp.array(robot.workspace.middle) + 0.125
    keys = jax.random.split(jax.random.key(0), 1000)
    for start in (robot.rest, robot.place):
        states = jax.vmap(start, (0, None))(keys, position)
        assert states.shape == (1000, robot.state_size) and states.dtype == jnp.float32
        # exact but for the arm, whose posture is found by iteration
        away = np.linalg.norm(robot.position(states) - position, axis=1)
        assert np.quantile(away, 0.99) <= (1e-3 if name == "panda" else 0.0)


def test_a_unicycle_starts_at_rest_with_a_uniform_heading():
    keys = jax.random.split(jax.random.key(1), 4000)
    states = jax.vmap(Unicycle().rest, (0, None))(keys, jnp.zeros(2))
    np.testing.assert_array_equal(states[:, 3], 0.0)
    _check_uniform(states[:, 2], -np.pi, np.pi)


def test_a_placed_unicycle_has_heading_and_speed_of_its_own():
    keys = jax.random.split(jax.random.key(2), 4000)
    states = jax.vmap(Unicycle().place, (0, None))(keys, jnp.zeros(2))
    _check_uniform(states[:, 2], -np.pi, np.pi)
    _check_uniform(states[:, 3], -0.5, 1.5)
    assert abs(np.corrcoef(states[:, 2], states[:, 3])[0, 1]) < 0.1


def _check_uniform(values, low, high):
    """Kolmogorov-Smirnov at 4000 samples: 0.035 is beyond the 0.01 % point; the seed is fixed."""
    share = (np.sort(values) - low) / (high - low)
    assert share.min() >= 0 and share.max() <= 1
    assert np.abs(share - np.linspace(0, 1, len(share))).max() < 0.035


def test_a_unicycle_sees_vectors_from_its_seat():
    state = jnp.array([3.0, 4.0, np.pi / 2, 1.5])  # looks along +y
    vectors = jnp.array([[[0.0, 2.0], [1.0, 0.0]], [[-3.0, 0.0], [0.0, -1.0]]])
    expected = [[[2.0, 0.0], [0.0, -1.0]], [[0.0, 3.0], [-1.0, 0.0]]]
    np.testing.assert_allclose(Unicycle().to_frame(state, vectors), expected, atol=1e-6)
    np.testing.assert_allclose(Unicycle().observe(state), [0.5])


def test_a_linear_robot_has_nothing_to_turn():
    vectors = jnp.array([[1.0, 2.0], [3.0, 4.0]])
    np.testing.assert_array_equal(Linear().to_frame(jnp.ones(2), vectors), vectors)
    assert Linear().observe(jnp.ones(2)).shape == (0,)


def test_observations_are_free_of_position_and_heading():
    states = jnp.array([[0.0, 0.0, 0.0, 0.7], [4.0, -3.0, 2.0, 0.7]])
    seen = jax.vmap(Unicycle().observe)(states)
    np.testing.assert_array_equal(seen[0], seen[1])


def test_the_planning_speed_can_be_driven():
    linear, unicycle = Linear(), Unicycle()
    ahead = linear.step(jnp.zeros(2), jnp.array([1.0, 0.0]))
    np.testing.assert_allclose(ahead[0], linear.speed, rtol=1e-6)
    state = jnp.zeros(4)
    for _ in range(4):
        state = unicycle.step(state, jnp.array([0.0, 1.0]))
    assert state[3] * unicycle.dt >= unicycle.speed


@ROBOTS
def test_robots_describe_themselves(name):
    robot = ENVS[name]
    assert robot.name == name
    assert len(robot.state_names) == robot.state_size
    assert len(robot.action_names) == robot.action_size
    assert len(robot.workspace.arena) == robot.position_size
    assert hash(robot) == hash(type(robot)())  # static under jit: equal robots compile once
