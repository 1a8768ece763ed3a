"""Fit the fast model of the walking ant to true physics: `python -m envs.ant.gait_training.fit`.

Waypoints that keep their distance for 0.2 to 2 s are carried out in true physics; the constants
of `Ant.step` are those whose predictions of the next second are closest. Prints them with the
residuals; they are copied to `envs/ant/robot.py` by hand.
"""

import json

import numpy as np
from scipy.optimize import least_squares

from envs.ant.gait import REACH, Gait, shipped_gait
from envs.ant.gait_training.measure import standing_states
from envs.ant.model import DT, has_fallen
from envs.ant.native import NativePhysics

ANTS, STEPS, AHEAD = 256, 200, 20


def walks(gait: Gait, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions [STEPS + 1, N, 2] and waypoints [STEPS, N, 2] of ants that did not fall."""
    random, physics = np.random.default_rng(seed), NativePhysics(gait, REACH)
    states, left = standing_states(random, ANTS), np.zeros(ANTS, int)
    waypoint, fallen = np.zeros((ANTS, 2)), np.zeros(ANTS, bool)
    positions, waypoints = [states[:, :2]], []
    for _ in range(STEPS):
        angle, distance = random.uniform(-np.pi, np.pi, ANTS), random.uniform(0, REACH, ANTS)
        fresh = distance[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)
        waypoint = np.where((left <= 0)[:, None], fresh, waypoint)
        left = np.where(left <= 0, random.integers(4, 40, ANTS), left - 1)
        states = physics.step(states, waypoint / REACH)
        fallen |= has_fallen(states)
        positions.append(states[:, :2])
        waypoints.append(waypoint)
    return np.stack(positions)[:, ~fallen], np.stack(waypoints)[:, ~fallen]


def predicted(constants, positions: np.ndarray, waypoints: np.ndarray) -> np.ndarray:
    """Displacements [STARTS, N, 2] in the next AHEAD steps by the fast model."""
    top, dead, near, response = constants
    starts = range(AHEAD, len(waypoints) - AHEAD, 10)
    moved = []
    for start in starts:
        past = slice(start - 5, start + 1)
        velocity = (positions[past][-1] - positions[past][0]) / (5 * DT)
        offset = np.zeros_like(velocity)
        for step in range(start, start + AHEAD):
            distance = np.linalg.norm(waypoints[step], axis=1, keepdims=True) + 1e-9
            share = np.clip((distance - dead) / (near - dead), 0, 1)
            wanted = top * share * waypoints[step] / distance
            velocity = velocity + response * (wanted - velocity)
            offset = offset + DT * velocity
        moved.append(offset)
    return np.stack(moved)


def fit(gait: Gait, seed: int = 1) -> dict[str, float]:
    """Constants of the fast model, and what they leave unexplained."""
    positions, waypoints = walks(gait, seed)
    starts = np.arange(AHEAD, len(waypoints) - AHEAD, 10)
    truth = positions[starts + AHEAD] - positions[starts]

    def error(constants):
        return (predicted(constants, positions, waypoints) - truth).ravel()

    found = least_squares(
        error, [1.5, 0.1, 0.6, 0.15], bounds=([0.5, 0, 0.2, 0.02], [3, 0.4, 1, 1])
    )
    velocity = np.diff(positions, axis=0) / DT
    smooth = np.stack([velocity[i : i + 10].mean(0) for i in range(len(velocity) - 10)])
    sway = velocity[5 : 5 + len(smooth)] - smooth
    names = ("top_speed", "dead", "near", "response")
    return dict(zip(names, found.x.round(4).tolist(), strict=True)) | {
        "residual_1s_rms": float(np.sqrt((error(found.x) ** 2).mean())),
        "travelled_1s_rms": float(np.sqrt((truth**2).mean())),
        "velocity_sway": float(sway.std()),
        "ants": positions.shape[1],
    }


if __name__ == "__main__":
    print(json.dumps(fit(shipped_gait()), indent=1))
