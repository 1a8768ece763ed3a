"""What the gait learns to do: follow waypoints that flee, reach those that stand, and stand there.

A command is a waypoint that keeps its distance from the ant (half of them), a goal 0.7 to 4 m
away, or a point to stand on; it changes every 1 to 4 s. A waypoint c away asks for the velocity

    w = TOP_SPEED * min(1, |c| / NEAR) * c / |c|

and the reward of a step is, v being the torso's mean velocity during the step,

    1.5 exp(-|v - w|^2 / 0.5) + 0.5 clip(v . c / |c|, -1, |w|) + 0.3 up_z
    - 0.02 (|u|^2 + excess of |u| over 1) - 10 if it falls.

Dimensions: N ants.
"""

from typing import NamedTuple

import numpy as np

from envs.ant.gait import motor_order, observe
from envs.ant.model import DT, POSITIONS, STANDING, VELOCITIES, has_fallen, rotation
from envs.ant.native import NativePhysics

TOP_SPEED, NEAR = 1.6, 0.5  # [m/s], [m]
LONGEST = 500  # steps of an episode
FLEEING, STANDING_GOAL = 0, 1


class Outcome(NamedTuple):
    """One step of N ants."""

    observation: np.ndarray  # [N, 29] after the step, before a new episode or command begins
    reward: np.ndarray  # [N]
    fell: np.ndarray  # [N]
    truncated: np.ndarray  # [N] the episode was as long as it may be
    along: np.ndarray  # [N] speed towards the waypoint [m/s]


class Chase:
    """N ants in true physics, each with a command."""

    def __init__(self, physics: NativePhysics, count: int, seed: int):
        self.physics, self.count = physics, count
        self.random = np.random.default_rng(seed)
        self.states = np.zeros((count, len(STANDING)))
        self.kind = np.zeros(count, int)
        self.waypoint = np.zeros((count, 2))  # relative if it flees, else in the world
        self.left = np.zeros(count, int)  # steps until the command changes
        self.age = self.random.integers(0, LONGEST, count)
        self.begin(np.arange(count))
        self.look()

    def command(self) -> np.ndarray:
        """Waypoints [N, 2] relative to the ants [m]."""
        still = self.kind[:, None] == STANDING_GOAL
        return np.where(still, self.waypoint - self.states[:, :2], self.waypoint)

    def look(self) -> np.ndarray:
        """Observations [N, 29]."""
        self.observation, self.turns = observe(self.states, self.command())
        return self.observation

    def begin(self, which: np.ndarray) -> None:
        """Set ants on their feet at the origin, some already moving."""
        random, count = self.random, len(which)
        states = np.tile(STANDING, (count, 1))
        states[:, :POSITIONS] += random.uniform(-0.1, 0.1, (count, POSITIONS))
        states[:, :2] = 0.0
        states[:, 2] = random.uniform(0.55, 0.65, count)
        half = random.uniform(-np.pi, np.pi, count) / 2
        states[:, 3:7] = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], -1)
        states[:, POSITIONS:] = 0.1 * random.standard_normal((count, VELOCITIES))
        speed = random.uniform(0, 1.5, count) * (random.random(count) < 0.3)
        states[:, POSITIONS : POSITIONS + 2] += speed[:, None] * directions(random, count)
        self.states[which] = states
        self.age[which] = 0
        self.change(which)

    def change(self, which: np.ndarray) -> None:
        """Give ants new commands."""
        random, count = self.random, len(which)
        draw = random.random(count)
        distance = np.select(
            [draw < 0.5, draw < 0.75],
            [random.uniform(0.1, 1.0, count) ** 0.5, random.uniform(0.7, 4.0, count)],
            random.uniform(0.0, 0.3, count),
        )
        offset = distance[:, None] * directions(random, count)
        self.kind[which] = np.where(draw < 0.5, FLEEING, STANDING_GOAL)
        still = np.expand_dims(draw >= 0.5, 1)
        self.waypoint[which] = np.where(still, self.states[which, :2] + offset, offset)
        self.left[which] = random.integers(20, 80, count)

    def act(self, actions: np.ndarray) -> Outcome:
        """One step with actions [N, 8] in the turned frames; fallen ants begin anew."""
        before, command = self.states[:, :2].copy(), self.command()
        torques = motor_order(np.clip(actions, -1.0, 1.0), self.turns)
        self.states = self.physics.torque_step(self.states, torques)
        self.states[~np.isfinite(self.states).all(axis=1)] = -STANDING  # upside down: it fell
        self.age += 1
        self.left -= 1
        fell = has_fallen(self.states)
        velocity = np.where(fell[:, None], 0.0, (self.states[:, :2] - before) / DT)
        reward, along = _reward(velocity, command, actions, self.states, fell)
        seen = self.look()
        truncated = (self.age >= LONGEST) & ~fell
        over = np.flatnonzero(fell | truncated)
        late = np.flatnonzero((self.left <= 0) & ~fell & ~truncated)
        self.begin(over)
        self.change(late)
        if len(over) + len(late):
            self.look()
        return Outcome(seen, reward, fell, truncated, along)


def _reward(velocity, command, actions, states, fell) -> tuple[np.ndarray, np.ndarray]:
    """Reward [N] and speed towards the waypoint [N]."""
    distance = np.linalg.norm(command, axis=1) + 1e-9
    speed = TOP_SPEED * np.minimum(1.0, distance / NEAR)
    ahead = command / distance[:, None]
    error = ((velocity - speed[:, None] * ahead) ** 2).sum(1)
    along = (velocity * ahead).sum(1)
    up = np.where(fell, 0.0, rotation(states[:, 3:7])[:, 2, 2])
    excess = np.maximum(np.abs(actions) - 1.0, 0.0).sum(1)
    effort = (np.clip(actions, -1.0, 1.0) ** 2).sum(1) + excess
    gain = 1.5 * np.exp(-error / 0.5) + 0.5 * np.clip(along, -1.0, speed) + 0.3 * up
    return gain - 0.02 * effort - 10.0 * fell, along


def directions(random: np.random.Generator, count: int) -> np.ndarray:
    """Unit vectors [N, 2]."""
    angle = random.uniform(-np.pi, np.pi, count)
    return np.stack([np.cos(angle), np.sin(angle)], -1)
