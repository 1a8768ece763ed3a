"""Predicates of the state: margins against plain numbers, gradients against finite differences."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.task.inequalities import Inequality, inequality_arrays, inequality_margins
from core.task.quantities import axes_of, named_state, quantities_of, scales_of
from envs import ENVS, Robot
from envs.ant.model import POSITIONS

BEYOND = 32


def states_of(robot: Robot, count: int) -> np.ndarray:
    """States [N, n] of the robot in motion within its arena."""
    low, high = np.array(robot.workspace.arena).T
    random = np.random.default_rng(4)
    positions = jnp.asarray(random.uniform(low, high, (count, len(low))), jnp.float32)
    keys = jax.random.split(jax.random.key(1), count)
    return np.asarray(jax.vmap(robot.place)(keys, positions))


def of(robot: Robot, found: list[Inequality], state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    arrays = inequality_arrays(found, robot, 3, BEYOND)
    margin, gradient = inequality_margins(arrays, robot, jnp.asarray(state))
    return np.asarray(margin)[: len(found)], np.asarray(gradient)[: len(found)]


@pytest.mark.parametrize("robot", ENVS.values(), ids=ENVS)
def test_every_quantity_is_named_once_and_in_its_place(robot):
    names = [each.name for each in quantities_of(robot)]
    assert len(set(names)) == len(names) and all(name.isidentifier() for name in names)
    for state in states_of(robot, 3):
        values = np.asarray(named_state(robot, jnp.asarray(state)))
        assert values.shape == (len(names),)
        position = np.asarray(robot.position(jnp.asarray(state)))
        axes = "xyz"[: robot.position_size]
        np.testing.assert_allclose(
            [values[names.index(axis)] for axis in axes], position, atol=1e-6
        )


@pytest.mark.parametrize("robot", ENVS.values(), ids=ENVS)
def test_margins_are_slacks_over_the_norm_of_the_weights(robot):
    random = np.random.default_rng(0)
    quantities, scales = quantities_of(robot), scales_of(robot)
    names = [each.name for each in quantities]
    found = [
        Inequality(
            {name: float(random.normal()) for name in random.choice(names, 2, replace=False)},
            float(random.normal()),
            absolute=bool(number % 2),
            at_most=bool(number // 2 % 2),
            bound=float(random.uniform(0, 1)),
        )
        for number in range(8)
    ]
    for state in states_of(robot, 4):
        values = np.asarray(named_state(robot, jnp.asarray(state)), float)
        margins, _ = of(robot, found, state)
        for each, margin in zip(found, margins, strict=True):
            weight = np.array([each.weights.get(name, 0.0) for name in names])
            left = weight @ values + each.offset
            left = abs(left) if each.absolute else left
            slack = each.bound - left if each.at_most else left - each.bound
            expected = slack / np.linalg.norm(weight / scales)
            assert margin == pytest.approx(expected, rel=1e-4, abs=1e-4)


@pytest.mark.parametrize("robot", ENVS.values(), ids=ENVS)
def test_gradients_along_the_position(robot):
    """Exact for x + 2 y with anything else beside it, zero for what the position leaves alone."""
    others = [each.name for each in quantities_of(robot) if each.name not in "xyz"]
    own = {others[-1]: 0.5} if others else {}
    found = [
        Inequality({"x": 1.0, "y": 2.0, **own}, 0.0, False, True, 0.3),
        Inequality({"x": 1.0, "y": 2.0}, 0.0, True, False, 0.3),
    ]
    if own:
        found.append(Inequality(own, 0.0, True, True, 0.3))
    for state in states_of(robot, 3):
        margins, gradients = of(robot, found, state)
        values = np.asarray(named_state(robot, jnp.asarray(state)), float)
        axes, step = axes_of(robot), 1e-3
        for axis in range(robot.position_size):
            moved = values + step * axes[:, axis]
            for row, each in enumerate(found):
                names = [quantity.name for quantity in quantities_of(robot)]
                weight = np.array([each.weights.get(name, 0.0) for name in names])
                gain = (1 if each.at_most else -1) / np.linalg.norm(weight / scales_of(robot))
                lefts = [weight @ point for point in (values, moved)]
                lefts = [abs(left) if each.absolute else left for left in lefts]
                change = gain * (lefts[0] - lefts[1]) / step
                assert gradients[row, axis] == pytest.approx(change, abs=1e-3)
        if own:
            assert not gradients[-1].any()
        assert np.linalg.norm(gradients[1]) == pytest.approx(1.0, abs=1e-5)
        assert len(margins) == len(found)


def test_derived_quantities():
    """What is no entry of the state: speed, the arm's tip, the ant's lean."""
    quadrotor, ant = ENVS["quadrotor"], ENVS["ant"]
    for state in states_of(quadrotor, 3):
        named = dict(zip(_names(quadrotor), _values(quadrotor, state), strict=True))
        assert named["speed"] == pytest.approx(np.linalg.norm(state[3:6]), abs=1e-4)
        assert (named["vz"], named["roll"]) == pytest.approx((-state[5], state[6]), abs=1e-6)
    for state in states_of(ant, 3):
        named = dict(zip(_names(ant), _values(ant, state), strict=True))
        assert named["tilt"] == pytest.approx(0.0, abs=1e-3)
        planar = state[POSITIONS : POSITIONS + 2]
        assert named["speed"] == pytest.approx(np.linalg.norm(planar), abs=1e-4)
        half = 0.35
        leaning = state.copy()
        leaning[3:7] = (np.cos(half), np.sin(half), 0.0, 0.0)
        named = dict(zip(_names(ant), _values(ant, leaning), strict=True))
        assert named["tilt"] == pytest.approx(2 * half, abs=1e-3)


def _names(robot: Robot) -> list[str]:
    return [each.name for each in quantities_of(robot)]


def _values(robot: Robot, state: np.ndarray) -> np.ndarray:
    return np.asarray(named_state(robot, jnp.asarray(state)), float)
