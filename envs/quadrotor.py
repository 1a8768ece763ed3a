"""Quadrotor: a rigid body with four rotors (paper, App. A.2, "Quadrotor"; Tayebi, McGilvray 2006).

The state is the paper's, in its sign convention: gravity is +g e3 and the thrust acts along -e3
of the body, so z points *down* (north, east, down; the body's axes forward, right, down). With
R = Rz(psi) Ry(theta) Rx(phi), total thrust T and torque tau, dt = 0.1 s, explicit Euler:

    p' = p + v dt                Theta' = Theta + omega dt
    v' = v + (g e3 - T/m R e3) dt    omega' = omega + I^-1 (tau - omega x I omega) dt

The rates of the angles are the body's rates, as printed. Positions that scenes speak about, and
vectors of the world, are turned by half a turn about x, (x, -y, -z): z points *up* there.

The paper leaves open how motors make T and tau. Here: a plus frame, motors in front, right, back
and left, at distance l, with forces 0 <= f <= 1 N (hover needs 0.49 N) and drag torque c f:

    T = f1 + f2 + f3 + f4                tau_y = l (f1 - f3)
    tau_x = l (f4 - f2)                  tau_z = c (f1 - f2 + f3 - f4)

Default action: (thrust, roll, pitch, yaw rate), kept by an inner loop whose output are the four
forces. With `raw_motors` the action is the four forces themselves, as in the paper.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import jax
import jax.numpy as jnp

from core.task.protocols import Tuning
from envs.robot import Robot, Workspace


@dataclass(frozen=True)
class Quadrotor:
    """State (x, y, z, v, phi, theta, psi, omega) in [m, m/s, rad, rad/s], z down.

    Attributes:
        dt: Duration of a step in [s].
        raw_motors: Whether the action is the motor forces, hover * (1 + motor_range * u).
        mass: In [kg].
        inertia: Diagonal of I in [kg m^2].
        gravity: In [m/s^2].
        arm: Distance l of the motors from the centre in [m].
        drag: Drag torque over force, c, in [m].
        max_force: Largest force of a motor in [N].
        motor_range: Share of hover by which a raw action changes a force.
        thrust_range: Share of hover by which the action changes the thrust.
        max_tilt: Roll and pitch asked for at most in [rad].
        max_yaw_rate: Yaw rate asked for at most in [rad/s]; explicit Euler makes a fast spin gain
            energy.
        attitude_gains: Stiffness [1/s^2] and damping [1/s] of the inner loop in roll and pitch;
            critically damped in discrete time: both poles at 1/2.
        yaw_gain: Of the yaw rate, [1/s].
        speed: Planning speed in [m/step], 3.5 m/s.
        lag: Steps that a leg may need on top of its distance.
        length: Length in [m] that features and rewards count as 1.
        placed_speed: Largest speed of a placed robot in [m/s].
    """

    dt: float = 0.1
    raw_motors: bool = False
    mass: float = 0.2
    inertia: tuple[float, float, float] = (0.01, 0.01, 0.02)
    gravity: float = 9.81
    arm: float = 0.17
    drag: float = 0.02
    max_force: float = 1.0
    motor_range: float = 0.5
    thrust_range: float = 0.6
    max_tilt: float = 0.6
    max_yaw_rate: float = 1.0
    attitude_gains: tuple[float, float] = (25.0, 10.0)
    yaw_gain: float = 5.0
    speed: float = 0.35
    lag: float = 6.0
    length: float = 1.0
    placed_speed: float = 3.0
    workspace: Workspace = Workspace(
        ((-5.0, 5.0), (-5.0, 5.0), (0.0, 5.0)), spacing=0.3125, clearance=0.35, inset=0.15
    )
    tuning: Tuning = Tuning(gradual_stays=True, learning_rate=2.5e-3)
    drawn_as: str = "multirotor"
    name: str = "quadrotor"
    state_size: int = 12
    action_size: int = 4
    position_size: int = 3
    state_names: tuple[str, ...] = (
        "x [m]",
        "y [m]",
        "z [m]",
        "vx [m/s]",
        "vy [m/s]",
        "vz [m/s]",
        "phi [rad]",
        "theta [rad]",
        "psi [rad]",
        "wx [rad/s]",
        "wy [rad/s]",
        "wz [rad/s]",
    )

    @property
    def action_names(self) -> tuple[str, ...]:
        """Names of the action's entries."""
        if self.raw_motors:
            return ("f1", "f2", "f3", "f4")
        return ("thrust", "roll", "pitch", "yaw rate")

    @property
    def quantities(self) -> tuple[str, ...]:
        """Position and velocity in the scene's frame, z up; the angles and rates of the state."""
        return (
            *("x [m]", "y [m]", "z [m]", "vx [m/s]", "vy [m/s]", "vz [m/s]", "speed [m/s]"),
            *("roll [rad]", "pitch [rad]", "yaw [rad]", "p [rad/s]", "q [rad/s]", "r [rad/s]"),
        )

    def named(self, state: jax.Array) -> jax.Array:
        """Values [13] of `quantities`."""
        velocity = self.velocity(state)
        speed = jnp.sqrt((velocity**2).sum() + 1e-12)[None]
        return jnp.concatenate([self.position(state), velocity, speed, state[6:12]])

    @property
    def variants(self) -> Mapping[str, Robot]:
        """`raw-motors`: the action is the motor forces, as in the paper."""
        return {"raw-motors": replace(self, raw_motors=True)}

    @property
    def hover_force(self) -> float:
        """Force of each motor that carries the weight, in [N]."""
        return self.mass * self.gravity / 4

    def rest(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """Hovering at the position, level, heading uniform on the circle."""
        heading = jax.random.uniform(key, (1,), minval=-jnp.pi, maxval=jnp.pi)
        zeros = jnp.zeros(5)
        return jnp.concatenate([_flip(position), zeros, heading, zeros[:3]]).astype(jnp.float32)

    def place(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """In flight at the position: any heading and direction, slightly tilted and turning."""
        heading_key, course_key, speed_key, tilt_key, rate_key = jax.random.split(key, 5)
        heading = jax.random.uniform(heading_key, (1,), minval=-jnp.pi, maxval=jnp.pi)
        course = jax.random.normal(course_key, (3,))
        speed = self.placed_speed * jax.random.uniform(speed_key)
        velocity = speed * course / (jnp.linalg.norm(course) + 1e-6) * jnp.array([1.0, 1.0, 0.5])
        tilt = 0.2 * jax.random.normal(tilt_key, (2,))
        rates = jnp.array([0.5, 0.5, 0.2]) * jax.random.normal(rate_key, (3,))
        parts = [_flip(position), velocity, tilt, heading, rates]
        return jnp.concatenate(parts).astype(jnp.float32)

    def step(self, state: jax.Array, action: jax.Array) -> jax.Array:
        """One Euler step of dt with the clipped action."""
        return self.fly(state, self.motor_forces(state, action))

    def motor_forces(self, state: jax.Array, action: jax.Array) -> jax.Array:
        """Forces [4] in [N] that a normalised action asks for, within the motors' limits."""
        action = jnp.clip(action, -1.0, 1.0)
        if self.raw_motors:
            forces = self.hover_force * (1 + self.motor_range * action)
        else:
            forces = self._inner_loop(state, action)
        return jnp.clip(forces, 0.0, self.max_force)

    def fly(self, state: jax.Array, forces: jax.Array) -> jax.Array:
        """One Euler step of dt under motor forces [4] in [N]."""
        velocity, rates = state[3:6], state[9:12]
        f1, f2, f3, f4 = forces
        thrust = f1 + f2 + f3 + f4
        torque = jnp.stack(
            [self.arm * (f4 - f2), self.arm * (f1 - f3), self.drag * (f1 - f2 + f3 - f4)]
        )
        inertia = jnp.asarray(self.inertia)
        weight = jnp.array([0.0, 0.0, self.gravity])
        acceleration = weight - thrust / self.mass * down_axis(state)
        spin = (torque - jnp.cross(rates, inertia * rates)) / inertia
        change = jnp.concatenate([velocity, acceleration, rates, spin])
        return state + change * self.dt

    @property
    def begins_exactly(self) -> bool:
        """`rest` hovers at the position."""
        return True

    def farthest(self, step: int) -> tuple[float, float, float, float]:
        """Of a step [m]: four motors at full force in any direction, on top of gravity.

        Rest is level, and torques turn it only in the third step: the thrust of the steps 0 and 1
        is vertical, and moves the robot a step later.
        """
        thrust = 4 * self.max_force / self.mass
        level = max(step - 2, 0) * thrust * self.dt**2
        vertical = step * (thrust + self.gravity) * self.dt**2
        return level, level, vertical, math.hypot(level, vertical)

    def position(self, state: jax.Array) -> jax.Array:
        """Position [..., 3] in [m] in the scene's frame, z up."""
        return _flip(state[..., :3])

    def velocity(self, state: jax.Array) -> jax.Array:
        """Velocity [..., 3] in [m/s] in the scene's frame, z up."""
        return _flip(state[..., 3:6])

    def observe(self, state: jax.Array) -> jax.Array:
        """Velocity in the robot's frame over 3 m/s, tilt, and rates over 3 rad/s [9]."""
        level = state.at[8].set(0.0)
        own = self.to_frame(state, self.velocity(state)) / 3
        return jnp.concatenate(
            [
                jnp.clip(own, -4, 4),
                down_axis(level),
                jnp.clip(state[9:12] / 3, -4, 4),
            ]
        )

    def to_frame(self, state: jax.Array, vectors: jax.Array) -> jax.Array:
        """Scene vectors [..., 3] as (forward, left, up) of the heading."""
        cosine, sine = jnp.cos(state[8]), jnp.sin(state[8])
        x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
        return jnp.stack([cosine * x - sine * y, sine * x + cosine * y, z], axis=-1)

    def _inner_loop(self, state: jax.Array, action: jax.Array) -> jax.Array:
        """Forces [4] that keep thrust, roll, pitch and yaw rate."""
        stiffness, damping = self.attitude_gains
        thrust = 4 * self.hover_force * (1 + self.thrust_range * action[0])
        tilt = stiffness * (self.max_tilt * action[1:3] - state[6:8]) - damping * state[9:11]
        yaw = self.yaw_gain * (self.max_yaw_rate * action[3] - state[11])
        roll_torque, pitch_torque = jnp.asarray(self.inertia[:2]) * tilt / (2 * self.arm)
        yaw_torque = self.inertia[2] * yaw / (4 * self.drag)
        front_back = thrust / 4 + yaw_torque
        right_left = thrust / 4 - yaw_torque
        return jnp.stack(
            [
                front_back + pitch_torque,
                right_left - roll_torque,
                front_back - pitch_torque,
                right_left + roll_torque,
            ]
        )


def down_axis(state: jax.Array) -> jax.Array:
    """R e3 [3]: the body's axis along which the thrust pulls backwards."""
    phi, theta, psi = state[6], state[7], state[8]
    along = jnp.sin(theta) * jnp.cos(phi)
    across = -jnp.sin(phi)
    cosine, sine = jnp.cos(psi), jnp.sin(psi)
    down = jnp.cos(theta) * jnp.cos(phi)
    return jnp.stack([cosine * along - sine * across, sine * along + cosine * across, down])


def _flip(vectors: jax.Array) -> jax.Array:
    """Between z down and z up: half a turn about x, its own inverse."""
    return jnp.asarray(vectors) * jnp.array([1.0, -1.0, -1.0])
