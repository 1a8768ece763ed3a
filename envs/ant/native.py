"""The ant's true physics in native MuJoCo: on a CPU tens of times as fast as MJX."""

from typing import Any

import numpy as np

from envs.ant.gait import Gait
from envs.ant.model import DT, STATE, SUBSTEPS, ant_model, is_sound
from envs.ant.pool import Borrowed

THREADS = 2
"""Of one simulation."""


class NativePhysics:
    """Closed loop of gait and `mujoco.rollout`; several threads may use it at once."""

    def __init__(self, gait: Gait, reach: float) -> None:
        """A simulator.

        Args:
            gait: turns waypoints into torques.
            reach: length of a waypoint at action 1 [m].
        """
        self._gait, self._reach = gait, reach
        self._simulators = Borrowed(_Simulator)

    def warm_up(self, count: int) -> None:
        """Nothing: no number of ants is compiled for."""

    def step(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """States [N, 29] after a control step towards the waypoints `reach` * actions [N, 2]."""
        states = np.asarray(states, float)
        waypoints = self._reach * np.clip(np.asarray(actions, float), -1.0, 1.0)
        return self.torque_step(states, self._gait.torques(states, waypoints))

    def torque_step(self, states: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """States [N, 29] after a control step with torques [N, 8]; NaN where it broke down."""
        states = np.asarray(states, float)
        sound = is_sound(states) & np.isfinite(torques).all(1)
        after = np.full_like(states, np.nan)
        if sound.any():
            with self._simulators.lent() as simulate:
                moved = simulate(states[sound], np.asarray(torques, float)[sound])
            after[sound] = np.where(is_sound(moved)[:, None], moved, np.nan)
        return after


class _Simulator:
    """One pool of MuJoCo's threads with their data."""

    def __init__(self) -> None:
        from mujoco import (  # noqa: PLC0415 - heavy
            MjData,  # pyright: ignore[reportAttributeAccessIssue]
            rollout,
        )

        self._model = ant_model()
        self._data = [MjData(self._model) for _ in range(THREADS)]
        self._rollout: Any = rollout.Rollout(nthread=THREADS)

    def __call__(self, states: np.ndarray, torques: np.ndarray) -> np.ndarray:
        """States [N, 29] after a control step with torques [N, 8]."""
        full = np.concatenate([np.zeros((len(states), 1)), states], 1)  # time first
        control = np.repeat(torques[:, None], SUBSTEPS, 1)
        visited = np.empty((len(states), SUBSTEPS, STATE + 1))
        sensors = np.empty((len(states), SUBSTEPS, self._model.nsensordata))
        self._rollout.rollout(
            [self._model] * len(states),
            self._data,
            full,
            control,
            skip_checks=True,
            nstep=SUBSTEPS,
            state=visited,
            sensordata=sensors,
        )
        after = visited[:, -1, 1:].copy()
        # MuJoCo puts a diverged ant back at the origin, sound again, and its clock back to zero.
        after[visited[:, -1, 0] < DT - 0.5 * self._model.opt.timestep] = np.nan
        return after
