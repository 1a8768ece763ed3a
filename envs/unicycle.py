"""Unicycle: a car-like robot (paper, App. A.2, "Unicycle").

    x' = x + v cos(theta) dt      theta' = theta + omega dt
    y' = y + v sin(theta) dt      v' = v + a dt,             dt = 0.2 s

Explicit Euler exactly as printed: the position moves with the old heading and speed. Limits
|omega| <= 1 rad/s and |a| <= 4 m/s^2. The speed is neither limited nor kept positive (the paper
limits only the controls), and the heading is not wrapped.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import jax
import jax.numpy as jnp

from core.task.protocols import Tuning
from envs.robot import Robot, Workspace


@dataclass(frozen=True)
class Unicycle:
    """State (x, y, theta, v) in [m, m, rad, m/s]; action (omega, a) in units of their limits.

    Attributes:
        dt: Duration of a step in [s].
        max_turn_rate: Limit of omega in [rad/s].
        max_acceleration: Limit of a in [m/s^2].
        speed: Planning speed in [m/step], 1.75 m/s: a turn at v needs a radius of v / 1 rad/s, so
            on paths among obstacles and with stops in regions the robot averages less than on a
            straight line, where nothing limits it.
        lag: Steps that a leg may need on top of its distance, for turning and starting.
        length: Length in [m] that features and rewards count as 1.
        placed_speed: Range of the speed in [m/s] of a placed robot.
        speed_scale: Speed in [m/s] that is observed as 1.
    """

    dt: float = 0.2
    max_turn_rate: float = 1.0
    max_acceleration: float = 4.0
    speed: float = 0.35
    lag: float = 3.0
    length: float = 1.0
    placed_speed: tuple[float, float] = (-0.5, 1.5)
    speed_scale: float = 3.0
    workspace: Workspace = Workspace(((-5.0, 5.0), (-5.0, 5.0)), spacing=0.125)
    tuning: Tuning = Tuning(violation=-3.5)
    drawn_as: str = "car"
    name: str = "unicycle"
    state_size: int = 4
    action_size: int = 2
    position_size: int = 2
    state_names: tuple[str, ...] = ("x [m]", "y [m]", "theta [rad]", "v [m/s]")
    action_names: tuple[str, ...] = ("omega", "a")

    @property
    def variants(self) -> Mapping[str, Robot]:
        """None."""
        return {}

    def rest(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """Standing at the position, heading uniform on the circle."""
        heading = jax.random.uniform(key, minval=-jnp.pi, maxval=jnp.pi)
        return self._state(position, heading, jnp.zeros(()))

    def place(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """At the position, heading uniform on the circle, speed uniform in `placed_speed`."""
        heading_key, speed_key = jax.random.split(key)
        heading = jax.random.uniform(heading_key, minval=-jnp.pi, maxval=jnp.pi)
        low, high = self.placed_speed
        return self._state(position, heading, jax.random.uniform(speed_key, (), None, low, high))

    def step(self, state: jax.Array, action: jax.Array) -> jax.Array:
        """One Euler step of dt with the clipped action."""
        x, y, heading, speed = state
        turn, acceleration = jnp.clip(action, -1.0, 1.0)
        return jnp.stack(
            [
                x + speed * jnp.cos(heading) * self.dt,
                y + speed * jnp.sin(heading) * self.dt,
                heading + turn * (self.max_turn_rate * self.dt),
                speed + acceleration * (self.max_acceleration * self.dt),
            ]
        )

    @property
    def begins_exactly(self) -> bool:
        """`rest` stands at the position."""
        return True

    def farthest(self, step: int) -> tuple[float, float, float]:
        """Of a step [m]: the speed, 0 at first, grows by `max_acceleration` dt a step at most."""
        distance = step * self.max_acceleration * self.dt**2
        return distance, distance, distance

    def position(self, state: jax.Array) -> jax.Array:
        """Position [..., 2] in [m]."""
        return state[..., :2]

    def observe(self, state: jax.Array) -> jax.Array:
        """Speed over `speed_scale` [1]."""
        return state[3:4] / self.speed_scale

    def to_frame(self, state: jax.Array, vectors: jax.Array) -> jax.Array:
        """Vectors [..., 2] as (forward, left) of the heading."""
        cosine, sine = jnp.cos(state[2]), jnp.sin(state[2])
        x, y = vectors[..., 0], vectors[..., 1]
        return jnp.stack([cosine * x + sine * y, cosine * y - sine * x], axis=-1)

    @staticmethod
    def _state(position: jax.Array, heading: jax.Array, speed: jax.Array) -> jax.Array:
        own = jnp.stack([heading, speed])
        return jnp.concatenate([jnp.asarray(position, jnp.float32), own]).astype(jnp.float32)
