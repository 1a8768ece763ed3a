"""The paper's dynamics (App. A.2) in float64 NumPy, equation by equation."""

import math

import numpy as np

DT = 0.2  # [s] of the planar robots
QUADROTOR_DT = 0.1  # [s]
PANDA_DT = 0.05  # [s]
MASS, GRAVITY, INERTIA = 0.2, 9.81, np.diag([0.01, 0.01, 0.02])
PANDA_LOW = [-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973]  # [rad]
PANDA_HIGH = [2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973]  # [rad]
PANDA_VELOCITY = [2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61]  # [rad/s]
PANDA_READY = [0, -math.pi / 4, 0, -3 * math.pi / 4, 0, math.pi / 2, math.pi / 4]  # [rad]
PANDA_AXES = np.array(
    [[0, 0, 1], [0, 1, 0], [0, 0, 1], [0, -1, 0], [0, 0, 1], [0, -1, 0], [0, 0, -1]], float
)
PANDA_POINTS = np.array(
    [
        [0, 0, 0.333],
        [0, 0, 0.333],
        [0, 0, 0.649],
        [0.0825, 0, 0.649],
        [0, 0, 1.033],
        [0, 0, 1.033],
        [0.088, 0, 1.033],
    ]
)
"""Axes and points on them with all joints at zero, read off Franka's drawing, in [m]."""


def linear_step(state, action) -> np.ndarray:
    """x' = x + v dt, y' = y + w dt with |v|, |w| <= 2 m/s."""
    x, y = state
    v, w = (2.0 * min(1.0, max(-1.0, float(u))) for u in action)
    return np.array([x + v * DT, y + w * DT])


def unicycle_step(state, action) -> np.ndarray:
    """Euler step of (x, y, theta, v) with |omega| <= 1 rad/s, |a| <= 4 m/s^2."""
    x, y, theta, v = state
    omega = min(1.0, max(-1.0, float(action[0])))
    a = 4.0 * min(1.0, max(-1.0, float(action[1])))
    return np.array(
        [
            x + v * math.cos(theta) * DT,
            y + v * math.sin(theta) * DT,
            theta + omega * DT,
            v + a * DT,
        ]
    )


def panda_step(state, action) -> np.ndarray:
    """theta' = theta + omega dt within the joints' limits."""
    omega = np.clip(np.asarray(action, float), -1, 1) * PANDA_VELOCITY
    return np.clip(np.asarray(state, float) + omega * PANDA_DT, PANDA_LOW, PANDA_HIGH)


def panda_tip(angles, tool: float = 0.1034) -> np.ndarray:
    """Tip [3] by the product of exponentials: the zero posture turned about each axis."""
    return _turned(angles, np.array([0.088, 0, 1.033 - 0.107 - tool]))


def panda_point(angles, point, joints: int) -> np.ndarray:
    """Where a point [3] of the zero posture goes that the first `joints` joints move, in [m]."""
    moving = [*angles[:joints], *[0.0] * (7 - joints)]
    return _turned(moving, np.asarray(point, float))


def panda_jacobian(angles) -> np.ndarray:
    """Derivative [3, 7] of the tip by central differences in [m/rad]."""
    steps = 1e-6 * np.eye(7)
    pairs = [(panda_tip(angles + step), panda_tip(angles - step)) for step in steps]
    return np.stack([(after - before) / 2e-6 for after, before in pairs], -1)


def _turned(angles, point: np.ndarray) -> np.ndarray:
    joints = list(zip(PANDA_AXES, PANDA_POINTS, angles, strict=True))
    for axis, origin, angle in reversed(joints):
        offset = point - origin
        along = axis * (axis @ offset)
        across = np.array(
            [
                axis[1] * offset[2] - axis[2] * offset[1],
                axis[2] * offset[0] - axis[0] * offset[2],
                axis[0] * offset[1] - axis[1] * offset[0],
            ]
        )
        point = origin + along + math.cos(angle) * (offset - along) + math.sin(angle) * across
    return point


def rotation(phi: float, theta: float, psi: float) -> np.ndarray:
    """Rz(psi) Ry(theta) Rx(phi), the matrices as printed in App. A.2."""
    about_x = [
        [1, 0, 0],
        [0, math.cos(phi), -math.sin(phi)],
        [0, math.sin(phi), math.cos(phi)],
    ]
    about_y = [
        [math.cos(theta), 0, math.sin(theta)],
        [0, 1, 0],
        [-math.sin(theta), 0, math.cos(theta)],
    ]
    about_z = [
        [math.cos(psi), -math.sin(psi), 0],
        [math.sin(psi), math.cos(psi), 0],
        [0, 0, 1],
    ]
    return np.array(about_z) @ np.array(about_y) @ np.array(about_x)


def quadrotor_fly(state, forces) -> np.ndarray:
    """The equations of App. A.2 under motor forces (front, right, back, left) in [N]."""
    p, v, angles, omega = np.split(np.asarray(state, float), 4)
    e3 = np.array([0.0, 0.0, 1.0])
    offsets = 0.17 * np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]])
    torque = np.sum(np.cross(offsets, -np.outer(forces, e3)), axis=0)
    torque += 0.02 * np.array([1, -1, 1, -1]) @ np.asarray(forces) * e3
    spin = np.linalg.inv(INERTIA) @ (torque - np.cross(omega, INERTIA @ omega))
    pull = np.sum(forces) / MASS * rotation(*angles) @ e3
    rates = [v, GRAVITY * e3 - pull, omega, spin]
    return np.asarray(state, float) + QUADROTOR_DT * np.concatenate(rates)


def quadrotor_step(state, action) -> np.ndarray:
    """The inner loop's wishes for thrust and torques, solved for the forces, then `fly`."""
    u = np.clip(np.asarray(action, float), -1, 1)
    roll, pitch = state[6:8]
    wx, wy, wz = state[9:12]
    wanted = [
        MASS * GRAVITY * (1 + 0.6 * u[0]),
        0.01 * (25 * (0.6 * u[1] - roll) - 10 * wx),
        0.01 * (25 * (0.6 * u[2] - pitch) - 10 * wy),
        0.02 * 5 * (u[3] - wz),
    ]
    mixing = [[1, 1, 1, 1], [0, -0.17, 0, 0.17], [0.17, 0, -0.17, 0], [0.02, -0.02, 0.02, -0.02]]
    forces = np.linalg.solve(mixing, wanted)
    return quadrotor_fly(state, np.clip(forces, 0, 1))


def ant_step(state, action):
    """The fast model of `envs/ant/robot.py` for the velocity; the posture stays."""
    state, waypoint = np.array(state, float), 0.7 * np.clip(np.asarray(action, float), -1, 1)
    distance = np.hypot(*waypoint)
    wanted = 1.47 * np.clip((distance - 0.08) / (0.49 - 0.08), 0, 1) * waypoint / distance
    state[15:17] += 0.18 * (wanted - state[15:17])
    state[:2] += 0.05 * state[15:17]
    return state


STEPS = {
    "linear": linear_step,
    "unicycle": unicycle_step,
    "panda": panda_step,
    "quadrotor": quadrotor_step,
    "ant": ant_step,
}


def position(robot: str, state) -> np.ndarray:
    """Position [d] in [m] in the scene's frame of one state [n]."""
    match robot:
        case "panda":
            return panda_tip(state)
        case "quadrotor":
            return np.asarray(state, float)[:3] * [1, -1, -1]
    return np.asarray(state, float)[:2]


def rollout(robot: str, initial, actions) -> np.ndarray:
    """States [T + 1, n] from an initial state [n] under actions [T, m]."""
    states = [np.asarray(initial, float)]
    for action in actions:
        states.append(STEPS[robot](states[-1], action))
    return np.stack(states)
