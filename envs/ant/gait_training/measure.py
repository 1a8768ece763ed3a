"""How good a gait is, in true physics: goals, falls, speeds, standing.

`python -m envs.ant.gait_training.measure` prints the figures of the shipped gait.
"""

import json

import numpy as np

from envs.ant.gait import Gait, shipped_gait
from envs.ant.gait_training.chase import directions
from envs.ant.model import DT, STANDING, has_fallen
from envs.ant.native import NativePhysics

SECONDS = 10.0
LATE = 60  # steps after which an ant walks as it goes on walking


def measure(gait: Gait, count: int = 512, seed: int = 12345) -> dict[str, float]:
    """Figures of a gait from `count` rollouts of each kind."""
    physics, random = NativePhysics(gait, 1.0), np.random.default_rng(seed)
    figures = _goals(physics, random, count)
    for distance in (1.0, 0.25):
        figures |= _chases(physics, random, count, distance)
    return figures | _turns(physics, random, count) | _standing(physics, random, count)


def standing_states(random: np.random.Generator, count: int) -> np.ndarray:
    """Ants [N, 29] at rest at the origin, headings at random."""
    states = np.tile(STANDING, (count, 1))
    half = random.uniform(-np.pi, np.pi, count) / 2
    states[:, 3], states[:, 6] = np.cos(half), np.sin(half)
    return states


def _goals(physics, random, count) -> dict[str, float]:
    """A goal 3 m away: reached within 0.5 m in 5 s; afterwards, how close it stands."""
    states, goal = standing_states(random, count), 3.0 * directions(random, count)
    arrived, close = np.full(count, np.inf), []
    for step in range(round(SECONDS / DT)):
        states = physics.step(states, goal - states[:, :2])
        distance = np.linalg.norm(goal - states[:, :2], axis=1)
        reached = (distance < 0.5) & ~has_fallen(states) & np.isinf(arrived)
        arrived[reached] = (step + 1) * DT
        if step >= 140:
            close.append(distance)
    return {
        "goal_3m_in_5s": float((arrived <= 5.0).mean()),
        "goal_3m_seconds_p90": float(np.quantile(arrived, 0.9)),
        "standing_error_mean": float(np.mean(close)),
        "standing_error_p95": float(np.quantile(close, 0.95)),
    }


def _chases(physics, random, count, distance) -> dict[str, float]:
    """A waypoint that flees straight: the speed towards it, and falls per 1000 steps."""
    states, ahead = standing_states(random, count), directions(random, count)
    steps, fallen, speeds = round(SECONDS / DT), np.zeros(count, bool), []
    lasted = 0
    for step in range(steps):
        before = states[:, :2].copy()
        lasted += int((~fallen).sum())
        states = physics.step(states, distance * ahead)
        fallen |= has_fallen(states)
        if step >= LATE:
            along = ((states[:, :2] - before) * ahead).sum(1) / DT
            speeds.append(along[~fallen])
    return {
        f"speed_at_{distance:g}m": float(np.concatenate(speeds).mean()),
        f"falls_per_1000_at_{distance:g}m": float(1000 * fallen.sum() / lasted),
    }


def _turns(physics, random, count) -> dict[str, float]:
    """A waypoint 1 m away that changes its direction every 1 to 4 s: falls per 1000 steps."""
    states, ahead = standing_states(random, count), directions(random, count)
    left, fallen, lasted = random.integers(20, 80, count), np.zeros(count, bool), 0
    for _ in range(2 * round(SECONDS / DT)):
        lasted += int((~fallen).sum())
        states = physics.step(states, ahead)
        fallen |= has_fallen(states)
        left -= 1
        ahead = np.where((left <= 0)[:, None], directions(random, count), ahead)
        left = np.where(left <= 0, random.integers(20, 80, count), left)
    return {"falls_per_1000_turning": float(1000 * fallen.sum() / lasted)}


def _standing(physics, random, count) -> dict[str, float]:
    """Ten seconds on the spot: the share that stays up, and how far it drifts."""
    states = standing_states(random, count)
    for _ in range(round(SECONDS / DT)):
        states = physics.step(states, -states[:, :2])
    drift = np.linalg.norm(states[:, :2], axis=1)
    return {
        "stands_10s": float((~has_fallen(states)).mean()),
        "drift_p95": float(np.quantile(drift, 0.95)),
    }


if __name__ == "__main__":
    print(json.dumps(measure(shipped_gait()), indent=1))
