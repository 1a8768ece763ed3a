"""Franka Panda: a seven-joint arm as an integrator of joint velocities (paper, App. A.2).

    theta_i' = clip(theta_i + omega_i dt, joint limits),  dt = 0.05 s

Limits of joints and velocities are Franka's (Franka Control Interface documentation, "Robot and
interface specifications"), as are the parameters of Craig's modified Denavit-Hartenberg table.
The position that formulas speak about is the point between the fingers of Franka's hand, 0.1034 m
in front of the flange, in the frame of the robot's base: x forward, z up, origin at its foot.

The paper's predicates are about the end effector alone; so are they here by default. With `links`
obstacles are held against the whole arm: a region that the formula only ever forbids is entered
as soon as a link enters it. Its margin is then the largest over the arm, and `!B` holds where it
is negative. Regions that are also to be visited, and the walls of the workspace, in one of which
the arm stands, remain the end effector's. Links are capsules (`LINKS`), each covered by balls:
nothing in a capsule is missed, and a ball reaches at most 9 mm beyond it.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp

from core.task.protocols import Tuning
from envs.robot import Robot, Workspace

DENAVIT_HARTENBERG = (
    (0.0, 0.333, 0),
    (0.0, 0.0, -1),
    (0.0, 0.316, 1),
    (0.0825, 0.0, 1),
    (-0.0825, 0.384, -1),
    (0.0, 0.0, 1),
    (0.088, 0.0, 1),
)
"""(a [m], d [m], alpha in quarter turns) of each joint."""

FLANGE = 0.107
"""From the seventh joint's origin to the flange [m]."""

LINKS = (
    ("shoulder", "elbow", 0.07),
    ("elbow", "elbow pivot", 0.07),
    ("forearm", "wrist", 0.06),
    ("wrist", "hand", 0.06),
    ("hand", "palm", 0.05),
)
"""Capsules of the arm: the points between which each extends and its radius [m], about those of
Franka's housings. The hand's ends 5 mm above the tip: the fingers are thinner than it."""

BALLS = (6, 3, 7, 3, 5)
"""Balls that cover each capsule."""

PALM = 0.045
"""Where the hand's capsule ends, from the flange [m]."""

READY = (0.0, -0.7853982, 0.0, -2.3561945, 0.0, 1.5707963, 0.7853982)
"""Franka's ready posture [rad]."""


@dataclass(frozen=True)
class Panda:
    """State: joint angles [7] in [rad]; action: joint velocities in units of their limits.

    Attributes:
        dt: Duration of a step in [s].
        low: Least joint angles in [rad].
        high: Largest joint angles in [rad].
        max_velocity: Largest joint velocities in [rad/s].
        links: Whether obstacles are held against the links too.
        tool: From the flange to the point between the fingers in [m].
        speed: Planning speed of the end effector in [m/step], 0.9 m/s: what the slowest direction
            allows from the ready posture.
        lag: Steps that a leg may need on top of its distance.
        length: Length in [m] that features and rewards count as 1.
        frame_gain: Factor on vectors seen from the joints, in [1/m].
        spread: How far a placed arm's posture is from the ready posture before its end effector
            is brought to the position, [rad].
        iterations: Steps of inverse kinematics.
        damping: Of inverse kinematics, [m^2].
    """

    dt: float = 0.05
    low: tuple[float, ...] = (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973)
    high: tuple[float, ...] = (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973)
    max_velocity: tuple[float, ...] = (2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61)
    links: bool = False
    tool: float = 0.1034
    speed: float = 0.045
    lag: float = 3.0
    length: float = 0.2
    frame_gain: float = 2.0
    spread: float = 0.6
    iterations: int = 15
    damping: float = 1e-3
    workspace: Workspace = Workspace(
        ((0.1, 0.86), (-0.7, 0.7), (0.0, 1.0)),
        spacing=0.04,
        clearance=0.03,
        inset=0.02,
        reach=((-0.855, 0.86), (-0.855, 0.855), (0.0, 1.188)),
    )
    tuning: Tuning = Tuning()
    drawn_as: str = "arm"
    name: str = "panda"
    state_size: int = 7
    action_size: int = 7
    position_size: int = 3
    state_names: tuple[str, ...] = tuple(f"joint {i} [rad]" for i in range(1, 8))
    action_names: tuple[str, ...] = tuple(f"omega {i}" for i in range(1, 8))

    @property
    def quantities(self) -> tuple[str, ...]:
        """Position of the end effector, and the joint angles."""
        return ("x [m]", "y [m]", "z [m]", *(f"q{i} [rad]" for i in range(1, 8)))

    def named(self, state: jax.Array) -> jax.Array:
        """Values [10] of `quantities`."""
        return jnp.concatenate([self.position(state), state])

    @property
    def variants(self) -> Mapping[str, Robot]:
        """`links`: obstacles are held against the whole arm."""
        return {"links": replace(self, links=True)}

    def rest(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """The end effector at the position, the posture close to the ready posture."""
        return self._reach(0.1, key, position)

    def place(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """The end effector at the position, the posture at random (the arm is redundant)."""
        return self._reach(self.spread, key, position)

    def move(self, state: jax.Array, position: jax.Array) -> jax.Array:
        """The end effector brought to the position, the posture changed little."""
        return self._brought(state, jnp.asarray(position, jnp.float32))

    def step(self, state: jax.Array, action: jax.Array) -> jax.Array:
        """Turn every joint for dt at its velocity; a joint stops at its limit."""
        change = jnp.clip(action, -1.0, 1.0) * (jnp.asarray(self.max_velocity) * self.dt)
        return jnp.clip(state + change, jnp.asarray(self.low), jnp.asarray(self.high))

    def farthest(self, step: int) -> tuple[float, float, float, float]:
        """Of a step [m]: all joints at full speed, each with the arm beyond it stretched.

        A joint moves the end effector by its angle times the distance at most; turning one after
        the other in small parts leads to the same posture. The seventh turns about the tip.
        """
        del step
        lengths = [math.hypot(a, d) for a, d, _ in DENAVIT_HARTENBERG[2:]]
        lengths[-1] = math.hypot(DENAVIT_HARTENBERG[6][0], FLANGE + self.tool)
        beyond = [sum(lengths[max(joint - 1, 0) :]) for joint in range(6)]
        limits = self.max_velocity[:6]
        distance = sum(w * r for w, r in zip(limits, beyond, strict=True)) * self.dt
        return distance, distance, distance, distance

    def position(self, state: jax.Array) -> jax.Array:
        """Position [..., 3] of the end effector in [m]."""
        _, origins, tip = self.kinematics(state)
        del origins
        return tip

    def observe(self, state: jax.Array) -> jax.Array:
        """Joint angles scaled to [-1, 1] and the end effector's position in [m] [10]."""
        low, high = jnp.asarray(self.low), jnp.asarray(self.high)
        return jnp.concatenate([(2 * state - low - high) / (high - low), self.position(state)])

    def to_frame(self, state: jax.Array, vectors: jax.Array) -> jax.Array:
        """Vectors [..., 3] as the joints feel them [..., 7]: J^T v times `frame_gain`."""
        return self.frame_gain * (vectors @ self.jacobian(state))

    def kinematics(self, state: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
        """Axes [..., 7, 3] and origins [..., 7, 3] of the joints, tip [..., 3] of the tool."""
        turns, origins, tip = self.frames(state)
        return turns[..., 2], origins, tip

    def frames(self, state: jax.Array) -> tuple[jax.Array, jax.Array, jax.Array]:
        """Rotations [..., 7, 3, 3] and origins [..., 7, 3] of the links, tip [..., 3] of the tool.

        The columns of a rotation are the axes x, y, z of the link's frame; z is the joint's axis.
        """
        cosine, sine = jnp.cos(state), jnp.sin(state)
        shape = state.shape[:-1]
        x, y, z = (jnp.broadcast_to(axis, (*shape, 3)) for axis in jnp.eye(3, dtype=state.dtype))
        point = jnp.zeros((*shape, 3), state.dtype)
        turns, origins = [], []
        for joint, (a, d, alpha) in enumerate(DENAVIT_HARTENBERG):
            point = point + a * x
            if alpha:
                y, z = alpha * z, -alpha * y
            c, s = cosine[..., joint, None], sine[..., joint, None]
            x, y = c * x + s * y, c * y - s * x
            point = point + d * z
            turns.append(jnp.stack([x, y, z], -1))
            origins.append(point)
        tip = point + (FLANGE + self.tool) * z
        return jnp.stack(turns, -3), jnp.stack(origins, -2), tip

    def body(self, state: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Centres [24, 3] and radii [24] in [m] of balls that cover the links."""
        axes, origins, _ = self.kinematics(state)
        points = {
            "shoulder": origins[1],
            "elbow": origins[2],
            "elbow pivot": origins[3],
            "forearm": origins[4] - DENAVIT_HARTENBERG[4][1] * axes[4],
            "wrist": origins[5],
            "hand": origins[6],
            "palm": origins[6] + (FLANGE + PALM) * axes[6],
        }
        centers, radii = [], []
        for (begin, end, radius), count in zip(LINKS, BALLS, strict=True):
            start, along = points[begin], points[end] - points[begin]
            gap = jnp.linalg.norm(along) / (count - 1)
            centers.append(start + jnp.linspace(0.0, 1.0, count)[:, None] * along)
            radii.append(jnp.full(count, jnp.hypot(radius, gap / 2)))
        return jnp.concatenate(centers), jnp.concatenate(radii)

    def jacobian(self, state: jax.Array) -> jax.Array:
        """Derivative [3, 7] of the end effector's position in [m/rad]."""
        axes, origins, tip = self.kinematics(state)
        return jnp.cross(axes, tip - origins).T

    def _reach(self, spread: float, key: jax.Array, position: jax.Array) -> jax.Array:
        """A posture whose end effector is at the position, by damped least squares.

        Starts from the ready posture, turned towards the position and disturbed by `spread`.
        Positions out of reach give the posture that comes near.
        """
        position = jnp.asarray(position, jnp.float32)
        low, high = jnp.asarray(self.low), jnp.asarray(self.high)
        noise = spread * jax.random.uniform(key, (7,), minval=-1.0, maxval=1.0)
        towards = jnp.arctan2(position[1], position[0])
        start = jnp.asarray(READY, jnp.float32).at[0].add(towards) + noise
        return self._brought(jnp.clip(start, low, high), position)

    def _brought(self, start: jax.Array, position: jax.Array) -> jax.Array:
        """A posture near `start` whose end effector is at the position, or comes near."""
        low, high = jnp.asarray(self.low), jnp.asarray(self.high)

        def improve(state, _):
            axes, origins, tip = self.kinematics(state)
            jacobian = jnp.cross(axes, tip - origins).T
            error = position - tip
            error = error * jnp.minimum(1.0, 0.3 / (jnp.linalg.norm(error) + 1e-9))
            gram = jacobian @ jacobian.T + self.damping * jnp.eye(3)
            state = state + jacobian.T @ _solve(gram, error)
            return jnp.clip(state, low, high), None

        state, _ = jax.lax.scan(improve, start, length=self.iterations)
        return state


def _solve(matrix: jax.Array, vector: jax.Array) -> jax.Array:
    """Solution [3] of a 3 x 3 system by Cramer's rule: batched LAPACK calls are slower."""
    a, b, c = matrix
    bc, ca, ab = jnp.cross(b, c), jnp.cross(c, a), jnp.cross(a, b)
    return (vector[0] * bc + vector[1] * ca + vector[2] * ab) / (a @ bc)
