"""The gait: a policy that walks towards a waypoint, and stands where it is reached.

It sees the torso's frame turned by quarter turns until the waypoint lies within 45 degrees of
straight ahead: the ant looks the same after a quarter turn, so one way of walking serves all.
The same code runs on NumPy arrays and on JAX arrays; `xp` is `numpy` or `jax.numpy`.

Dimensions: N ants.
"""

import json
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

import numpy as np
from safetensors import safe_open
from safetensors.numpy import load

from envs.ant.model import MOTORS, POSITIONS, rotation

FEATURES = 29
SIGHT = 1.0
"""Distance beyond which a waypoint looks no farther [m]; learnt with."""

REACH = 0.7
"""Distance to which farther waypoints are drawn in [m]: the ant walks no faster towards farther
ones, but falls twice as often when they turn."""

KNEE_SIGN = np.array([1.0, -1.0, -1.0, 1.0])
"""Legs 2 and 3 have their ankles' axes the other way round."""

WEIGHTS = "gait.safetensors"


@dataclass(frozen=True, eq=False)
class Gait:
    """Two hidden layers of tanh over normalised observations.

    Attributes:
        mean: Of the observations [29].
        deviation: Of the observations [29].
        layers: (weights, bias) of each layer.
    """

    mean: Any
    deviation: Any
    layers: tuple[tuple[Any, Any], ...]

    def torques(self, states: Any, waypoints: Any, xp: Any = np) -> Any:
        """Motor torques [N, 8] in [-1, 1] for states [N, 29] and waypoints [N, 2].

        Waypoints are relative to the torso, in the world's axes, in [m].
        """
        distance = xp.sqrt((waypoints**2).sum(1, keepdims=True))
        near = waypoints * (REACH / xp.maximum(distance, REACH))
        observation, turns = observe(states, near, xp)
        return motor_order(xp.clip(self.act(observation, xp), -1.0, 1.0), turns, xp)

    def act(self, observation: Any, xp: Any = np) -> Any:
        """Mean actions [N, 8] in the turned frame."""
        value = normalised(observation, self.mean, self.deviation, xp)
        for weights, bias in self.layers[:-1]:
            value = xp.tanh(value @ weights + bias)
        weights, bias = self.layers[-1]
        return value @ weights + bias


def normalised(observation: Any, mean: Any, deviation: Any, xp: Any = np) -> Any:
    """Observations with zero mean and unit deviation, at most 8 deviations away."""
    return xp.clip((observation - mean) / deviation, -8.0, 8.0)


def observe(states: Any, waypoints: Any, xp: Any = np) -> tuple[Any, Any]:
    """What the gait sees [N, 29], and the number of quarter turns [N] of its frame.

    Height; up axis, velocity and angular velocity of the torso; hip and knee angles and rates of
    the legs, the first ahead on the left; cosine and sine of the waypoint's bearing and its
    distance, up to `SIGHT`.
    """
    matrix = rotation(states[:, 3:7], xp)
    up = matrix[:, 2, :]
    velocity = xp.einsum("nji,nj->ni", matrix, states[:, POSITIONS : POSITIONS + 3])
    spin = states[:, POSITIONS + 3 : POSITIONS + 6]
    ahead = xp.einsum("nji,nj->ni", matrix[:, :2, :2], waypoints)
    distance = xp.minimum(xp.sqrt((waypoints**2).sum(1)), SIGHT)
    bearing = xp.arctan2(ahead[:, 1], ahead[:, 0])
    turns = xp.round(bearing / (np.pi / 2)).astype(int) % 4
    bearing = bearing - turns * (np.pi / 2)
    angles, rates = states[:, 7:POSITIONS], states[:, POSITIONS + 6 :]
    legs = (xp.arange(4)[None] + turns[:, None]) % 4
    parts = [states[:, 2:3], *(_turned(vector, turns, xp) for vector in (up, velocity, spin))]
    for joints in (angles, rates):
        for values in (joints[:, 0::2], joints[:, 1::2] * KNEE_SIGN):
            parts.append(xp.take_along_axis(values, legs, 1))
    parts.append(xp.stack([xp.cos(bearing), xp.sin(bearing), distance], -1))
    return xp.concatenate(parts, -1), turns


def motor_order(actions: Any, turns: Any, xp: Any = np) -> Any:
    """Torques [N, 8] in the motors' order of actions [N, 8] = (hips, knees) in the turned frame.

    The motors are those of leg 4, then legs 1 to 3, hip and ankle of each.
    """
    legs = (xp.arange(4)[None] - turns[:, None]) % 4
    hips = xp.take_along_axis(actions[:, :4], legs, 1)
    knees = xp.take_along_axis(actions[:, 4:], legs, 1) * KNEE_SIGN
    order = np.array([3, 0, 1, 2])
    return xp.stack([hips[:, order], knees[:, order]], -1).reshape(-1, MOTORS)


def _turned(vectors: Any, turns: Any, xp: Any) -> Any:
    """Vectors [N, 3] of the torso's frame in the frame turned about z."""
    cosine, sine = (
        xp.asarray([1.0, 0.0, -1.0, 0.0])[turns],
        xp.asarray([0.0, 1.0, 0.0, -1.0])[turns],
    )
    x, y, z = vectors[:, 0], vectors[:, 1], vectors[:, 2]
    return xp.stack([cosine * x + sine * y, cosine * y - sine * x, z], -1)


@cache
def shipped_gait() -> Gait:
    """The gait that comes with the program (`envs.ant.gait_training` made it)."""
    return read_gait((resources.files("static") / "ant" / WEIGHTS).read_bytes())


def read_gait(data: bytes) -> Gait:
    """A gait from the bytes of its safetensors file."""
    arrays = load(data)
    count = sum(name.startswith("weights") for name in arrays)
    layers = tuple((arrays[f"weights{i}"], arrays[f"bias{i}"]) for i in range(count))
    return Gait(arrays["mean"], arrays["deviation"], layers)


def gait_metadata() -> dict[str, Any]:
    """How the shipped gait was made and what was measured of it."""
    with resources.as_file(resources.files("static") / "ant" / WEIGHTS) as path:
        with safe_open(path, "numpy") as file:
            return {key: json.loads(value) for key, value in file.metadata().items()}
