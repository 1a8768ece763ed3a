"""Closed loop of the gait and a simulator in JAX, compiled for each number of ants.

Dimensions: N ants.
"""

from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import Program, shape_of
from envs.ant.gait import Gait
from envs.ant.model import MOTORS, POSITIONS, STATE, WILD

TorqueStep = Callable[[jax.Array, jax.Array], jax.Array]
"""State [29] of one ant after a control step with torques [8]."""


class CompiledPhysics:
    """A simulator on whatever JAX runs on; several threads may use it at once."""

    def __init__(self, torque_step: TorqueStep, gait: Gait, reach: float) -> None:
        """A simulator.

        Args:
            torque_step: moves one ant.
            gait: turns waypoints into torques.
            reach: length of a waypoint at action 1 [m].
        """
        step = jax.vmap(_lost_if_unsound(torque_step))

        def torques(states, actions):
            return gait.torques(states, reach * jnp.clip(actions, -1.0, 1.0), jnp)

        self._torques, self._step = Program(torques, fused=True), Program(step, fused=True)

    def warm_up(self, count: int) -> None:
        """Compile what a step of N = count ants needs, so that no later one compiles."""
        states = shape_of(count, STATE, dtype=jnp.float32)
        self._torques.compile(states, shape_of(count, 2, dtype=jnp.float32))
        self._step.compile(states, shape_of(count, MOTORS, dtype=jnp.float32))

    def step(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """States [N, 29] after a control step towards the waypoints `reach` * actions [N, 2]."""
        now: Any = np.asarray(states, np.float32)
        wanted: Any = np.asarray(actions, np.float32)
        return np.asarray(self._step(now, self._torques(now, wanted)))

    def torque_step(self, states: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """States [N, 29] after a control step with torques [N, 8]; NaN where it broke down."""
        now: Any = np.asarray(states, np.float32)
        applied: Any = np.asarray(torques, np.float32)
        return np.asarray(self._step(now, applied))


def _lost_if_unsound(torque_step: TorqueStep) -> TorqueStep:
    """The same step, but NaN for an ant whose simulation breaks down."""

    def step(state, torques):
        after = torque_step(state, torques)
        sound = jnp.isfinite(after).all() & (jnp.abs(after[POSITIONS:]) < WILD).all()
        return jnp.where(sound, after, jnp.nan)

    return step
