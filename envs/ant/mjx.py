"""The ant's true physics in MJX: for GPUs and TPUs. Compiling takes most of a minute."""

from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from envs.ant.gait import Gait
from envs.ant.model import POSITIONS, SUBSTEPS, WILD, ant_model


class MjxPhysics:
    """Closed loop of gait and MJX, compiled once for each number of ants."""

    def __init__(self, gait: Gait, reach: float) -> None:
        """A simulator.

        Args:
            gait: turns waypoints into torques.
            reach: length of a waypoint at action 1 [m].
        """
        from mujoco import mjx  # noqa: PLC0415 - slow to import

        model = mjx.put_model(ant_model())
        blank = mjx.make_data(model)
        self._torque_step = jax.jit(partial(_torque_steps, mjx, model, blank))
        self._step = jax.jit(partial(_closed_loop, self._torque_step, gait, reach))

    def step(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """States [N, 29] after a control step towards the waypoints `reach` * actions [N, 2]."""
        return np.asarray(self._step(jnp.float32(states), jnp.float32(actions)))

    def torque_step(self, states: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """States [N, 29] after a control step with torques [N, 8]; NaN where it broke down."""
        return np.asarray(self._torque_step(jnp.float32(states), jnp.float32(torques)))


def _closed_loop(torque_step: Any, gait: Gait, reach: float, states: Any, actions: Any) -> Any:
    waypoints = reach * jnp.clip(actions, -1.0, 1.0)
    return torque_step(states, gait.torques(states, waypoints, jnp))


def _torque_steps(mjx: Any, model: Any, blank: Any, states: Any, torques: Any) -> Any:
    """A control step of each ant; rows that break down become NaN."""

    def one(state, control):
        data = blank.replace(qpos=state[:POSITIONS], qvel=state[POSITIONS:], ctrl=control)
        data, _ = jax.lax.scan(lambda d, _: (mjx.step(model, d), None), data, length=SUBSTEPS)
        after = jnp.concatenate([data.qpos, data.qvel])
        sound = jnp.isfinite(after).all() & (jnp.abs(data.qvel) < WILD).all()
        return jnp.where(sound, after, jnp.nan)

    return jax.vmap(one)(states, torques)
