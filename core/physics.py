"""Robots whose truth is simulated on the host.

A robot is in general what its `step` says. A robot with a `physics` is what that simulator says:
its `step` is then only a fast model of it, good for learning (see `envs.ant`). Episodes in true
physics are advanced by the same functions as all others: compiled code decides, the host
simulates, and compiled code continues with the *measured* state in the action's place.

Dimensions: N robots, n state, m action.
"""

from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from core.protocols import Array, Robot


class Physics(Protocol):
    """A batched simulator on the host; several threads may use it at once."""

    def step(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """States [N, n] after one step with the actions [N, m], clipped to [-1, 1].

        A row whose simulation breaks down comes back with numbers that are not finite; it
        neither raises nor disturbs the other rows.
        """
        ...


def physics_of(robot: Robot) -> Physics | None:
    """The simulator that is the robot's truth, or None where `robot.step` is."""
    make = getattr(robot, "physics", None)
    return None if make is None else make()


@dataclass(frozen=True)
class MeasuredRobot:
    """A robot whose next state is handed in, in the action's place, instead of simulated."""

    robot: Robot

    def __getattr__(self, name: str) -> Any:
        return getattr(self.robot, name)

    def step(self, state: Array, measured: Array) -> Array:
        """The measured state."""
        del state
        return measured
