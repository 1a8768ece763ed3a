"""Linear: a single integrator in the plane (paper, App. A.2, "Linear").

    x' = x + v dt,  y' = y + w dt,  dt = 0.2 s

The paper is silent on the limits of v and w: 2 m/s an axis here, 0.4 m a step.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from core.task.protocols import Tuning
from envs.robot import Robot, Workspace


@dataclass(frozen=True)
class Linear:
    """State (x, y) in [m]; action (v, w) in units of `max_velocity`.

    Attributes:
        dt: Duration of a step in [s].
        max_velocity: Limit of the velocity on each axis in [m/s].
        speed: Planning speed in [m/step]: the limit along an axis. Diagonal moves are faster, so
            it underrates the robot by up to a factor of sqrt(2), never overrates it.
        lag: Steps that a leg may need on top of its distance.
        length: Length in [m] that features and rewards count as 1.
    """

    dt: float = 0.2
    max_velocity: float = 2.0
    speed: float = 0.4
    lag: float = 1.0
    length: float = 1.0
    workspace: Workspace = Workspace(((-5.0, 5.0), (-5.0, 5.0)), spacing=0.125)
    tuning: Tuning = Tuning()
    drawn_as: str = "ball"
    name: str = "linear"
    state_size: int = 2
    action_size: int = 2
    position_size: int = 2
    state_names: tuple[str, ...] = ("x [m]", "y [m]")
    action_names: tuple[str, ...] = ("v", "w")

    @property
    def variants(self) -> Mapping[str, Robot]:
        """None."""
        return {}

    def rest(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """The position itself: the robot has neither heading nor speed."""
        del key
        return jnp.asarray(position, jnp.float32)

    def place(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """The position itself, as for `rest`."""
        return self.rest(key, position)

    def step(self, state: jax.Array, action: jax.Array) -> jax.Array:
        """Move for dt at the velocity `clip(action) * max_velocity`."""
        return state + jnp.clip(action, -1.0, 1.0) * (self.max_velocity * self.dt)

    @property
    def stride(self) -> tuple[float, float]:
        """Of a step [m]: its velocity is all that the robot is, so that exact plans know it."""
        axis = self.max_velocity * self.dt
        return axis, axis

    @property
    def begins_exactly(self) -> bool:
        """`rest` is the position itself."""
        return True

    def farthest(self, step: int) -> tuple[float, float, float]:
        """Of a step [m]: in x, in y and in all."""
        del step
        return *self.stride, math.hypot(*self.stride)

    def position(self, state: jax.Array) -> jax.Array:
        """Position [..., 2] in [m]."""
        return state[..., :2]

    def observe(self, state: jax.Array) -> jax.Array:
        """Nothing [0]: the position is all there is."""
        return state[:0]

    def to_frame(self, state: jax.Array, vectors: jax.Array) -> jax.Array:
        """The vectors themselves: the robot's frame is parallel to the world's."""
        del state
        return vectors
