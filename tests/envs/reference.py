"""The paper's dynamics (App. A.2) in float64 NumPy, equation by equation."""

import math

import numpy as np

DT = 0.2  # [s]


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


STEPS = {"linear": linear_step, "unicycle": unicycle_step}


def rollout(robot: str, initial, actions) -> np.ndarray:
    """States [T + 1, n] from an initial state [n] under actions [T, m]."""
    states = [np.asarray(initial, float)]
    for action in actions:
        states.append(STEPS[robot](states[-1], action))
    return np.stack(states)
