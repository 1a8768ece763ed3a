"""Ant as the waypoint layer sees it: an omnidirectional walker (paper, App. A.2, "Ant").

The truth is MuJoCo with the gait in the loop (`physics`); every verdict comes from there. The
action is a waypoint relative to the torso, c = reach * u, held for a step of 0.05 s.

`step` is a fast model of the closed loop, in which the waypoint layer learns:

    w = top_speed * clip((|c| - dead) / (near - dead), 0, 1) * c / |c|    the velocity asked for
    v' = v + response * (w - v),    p' = p + v' dt    (everything else stays as it is)

Fitted by `envs.ant.gait_training.fit` (seed 1). On other ants (seeds 2 to 4) under waypoints that
change every 0.2 to 2 s, its prediction 1 s ahead is off by 0.16-0.17 m rms an axis, of 0.6 m
travelled. It leaves out the torso's sway (0.23 m/s rms) and where a gait lets an ant drift: in
steady walks the speed differs by +-0.1 m/s between ants, sideways drift is 0.1 m/s rms, and the
truth hardly moves towards waypoints nearer than 0.15 m.
"""

import sys
from collections.abc import Mapping
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from functools import cache
from typing import Literal, get_args

import jax
import jax.numpy as jnp

from core.task.physics import Physics
from core.task.protocols import Tuning
from envs.ant.gait import REACH, shipped_gait
from envs.ant.model import DT, POSITIONS, STANDING, STATE, rotation
from envs.robot import Robot, Workspace

SimulatorName = Literal["native", "mjx", "brax"]


@dataclass(frozen=True)
class Ant:
    """State: qpos [15] and qvel [14] of brax's ant (see `envs.ant.model`); action: waypoint [2].

    Attributes:
        dt: Duration of a step in [s].
        simulator: Of the true physics: native MuJoCo, MJX, brax, or by what JAX runs on.
        reach: Length of a waypoint at action 1 in [m].
        top_speed: Speed in [m/s] to which waypoints at `near` and beyond lead.
        dead: Distance in [m] of a waypoint below which the ant stands.
        near: Distance in [m] of a waypoint below which it walks slower.
        response: Share of a velocity error that is gone after a step.
        speed: Planning speed in [m/step], 1.25 m/s.
        lag: Steps that a leg may need on top of its distance.
        length: Length in [m] that features and rewards count as 1.
        placed_speed: Largest speed of a placed ant in [m/s].
        speed_scale: Speed in [m/s] that is observed as 1.
    """

    dt: float = DT
    simulator: SimulatorName | Literal["auto"] = "auto"
    reach: float = REACH
    top_speed: float = 1.47
    dead: float = 0.08
    near: float = 0.49
    response: float = 0.18
    speed: float = 0.0625
    lag: float = 8.0
    length: float = 0.6
    placed_speed: float = 1.2
    speed_scale: float = 1.5
    workspace: Workspace = Workspace(
        ((-3.0, 3.0), (-3.0, 3.0)), spacing=0.1, clearance=0.2, inset=0.15
    )
    tuning: Tuning = Tuning(
        violation=-1.5,
        gradual_stays=True,
        learning_rate=2.5e-3,
        epochs=60,
        model_epochs=50,
        evaluation_states=128,
    )
    drawn_as: str = "spider"
    name: str = "ant"
    state_size: int = STATE
    action_size: int = 2
    position_size: int = 2
    state_names: tuple[str, ...] = (
        *("x [m]", "y [m]", "z [m]", "qw", "qx", "qy", "qz"),
        *(f"{joint} {leg} [rad]" for leg in range(1, 5) for joint in ("hip", "ankle")),
        *("vx [m/s]", "vy [m/s]", "vz [m/s]", "wx [rad/s]", "wy [rad/s]", "wz [rad/s]"),
        *(f"{joint} rate {leg} [rad/s]" for leg in range(1, 5) for joint in ("hip", "ankle")),
    )
    action_names: tuple[str, ...] = ("waypoint x", "waypoint y")

    @property
    def quantities(self) -> tuple[str, ...]:
        """Of the torso: position and height, velocity, speed over ground, and lean from upright."""
        return (
            *("x [m]", "y [m]", "z [m]", "vx [m/s]", "vy [m/s]", "vz [m/s]"),
            *("speed [m/s]", "tilt [rad]"),
        )

    def named(self, state: jax.Array) -> jax.Array:
        """Values [8] of `quantities`."""
        velocity = state[POSITIONS : POSITIONS + 3]
        speed = jnp.sqrt((velocity[:2] ** 2).sum() + 1e-12)
        upright = rotation(state[3:7], jnp)[2, 2]
        tilt = jnp.arccos(jnp.clip(upright, -1.0, 1.0))
        return jnp.concatenate([state[:3], velocity, jnp.stack([speed, tilt])])

    @property
    def variants(self) -> Mapping[str, Robot]:
        """One for each simulator of the true physics."""
        return {name: replace(self, simulator=name) for name in get_args(SimulatorName)}

    def rest(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """Standing at the position, heading uniform on the circle."""
        return self._standing(key, position, jnp.zeros(2))

    def place(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """On its feet at the position, moving in any direction at up to `placed_speed`."""
        heading_key, course_key, speed_key = jax.random.split(key, 3)
        course = jax.random.uniform(course_key, minval=-jnp.pi, maxval=jnp.pi)
        speed = self.placed_speed * jax.random.uniform(speed_key)
        velocity = speed * jnp.stack([jnp.cos(course), jnp.sin(course)])
        return self._standing(heading_key, position, velocity)

    def step(self, state: jax.Array, action: jax.Array) -> jax.Array:
        """The fast model's next state."""
        waypoint = self.reach * jnp.clip(action, -1.0, 1.0)
        distance = jnp.sqrt((waypoint**2).sum() + 1e-9)
        share = jnp.clip((distance - self.dead) / (self.near - self.dead), 0.0, 1.0)
        wanted = self.top_speed * share * waypoint / distance
        velocity = state[POSITIONS : POSITIONS + 2]
        velocity = velocity + self.response * (wanted - velocity)
        position = state[:2] + self.dt * velocity
        return state.at[:2].set(position).at[POSITIONS : POSITIONS + 2].set(velocity)

    @property
    def begins_exactly(self) -> bool:
        """`rest` stands at the position; how fast an ant can be at most is not known."""
        return True

    def position(self, state: jax.Array) -> jax.Array:
        """Position [..., 2] of the torso in [m]."""
        return state[..., :2]

    def observe(self, state: jax.Array) -> jax.Array:
        """Velocity of the torso over `speed_scale`, within two units [2]."""
        velocity = state[POSITIONS : POSITIONS + 2] / self.speed_scale
        return jnp.clip(velocity, -2.0, 2.0)

    def to_frame(self, state: jax.Array, vectors: jax.Array) -> jax.Array:
        """The vectors themselves: where the torso faces does not matter to a waypoint."""
        del state
        return vectors

    def physics(self) -> Physics:
        """The simulator that is the truth."""
        kind = self.simulator
        if kind == "auto":
            kind = "native" if jax.default_backend() == "cpu" else "mjx"
        return _physics(kind, self.reach)

    @staticmethod
    def _standing(key: jax.Array, position: jax.Array, velocity: jax.Array) -> jax.Array:
        half = jax.random.uniform(key, minval=-jnp.pi, maxval=jnp.pi) / 2
        state = jnp.asarray(STANDING, jnp.float32)
        state = state.at[:2].set(jnp.asarray(position, jnp.float32))
        state = state.at[3].set(jnp.cos(half)).at[6].set(jnp.sin(half))
        return state.at[POSITIONS : POSITIONS + 2].set(velocity)


@cache
def _physics(kind: SimulatorName, reach: float) -> Physics:
    """One simulator of each kind in a process; what it is made of is imported for it alone."""
    match kind:
        case "native":
            from envs.ant.native import NativePhysics  # noqa: PLC0415

            return NativePhysics(shipped_gait(), reach)
        case "mjx":
            from envs.ant.mjx import mjx_step as make_step  # noqa: PLC0415
        case "brax":
            from envs.ant.brax import brax_step as make_step  # noqa: PLC0415
    from envs.ant.compiled import CompiledPhysics  # noqa: PLC0415

    # mujoco.mjx prints on import that it found no warp; standard output is for results
    with redirect_stdout(sys.stderr):
        step = make_step()
    return CompiledPhysics(step, shipped_gait(), reach)
