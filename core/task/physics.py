"""Robots whose true physics is simulated on the host.

In general `step` defines a robot. If a robot has a `physics`, that simulator defines it, and its
`step` is only a fast model for learning (see `envs.ant`). Episodes in true
physics are advanced by the same functions as all others: compiled code decides, the host
simulates, and compiled code continues with the measured state.

Dimensions: N robots, n state, m action.
"""

from typing import Protocol

import numpy as np

from core.task.protocols import Robot


class Physics(Protocol):
    """A batched simulator on the host; several threads may use it at once."""

    def warm_up(self, count: int) -> None:
        """Compile whatever a step of N = count robots needs, so that no later step compiles."""
        ...

    def step(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """States [N, n] after one step with the actions [N, m], clipped to [-1, 1].

        A row whose simulation diverges is returned with numbers that are not finite; it neither
        raises nor affects the other rows.
        """
        ...


def physics_of(robot: Robot) -> Physics | None:
    """The simulator that defines the robot, or None if `robot.step` does."""
    make = getattr(robot, "physics", None)
    return None if make is None else make()
