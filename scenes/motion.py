"""How a region moves: from where it begins, along waypoints in time that are known beforehand.

Between two waypoints it goes straight and at constant speed; it stands before the first one and
after the last. A velocity is a path that never ends.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from scenes.checks import LARGEST_COORDINATE, SceneError

LAST_STEP = 10_000
"""Latest step of a waypoint."""

MOST_WAYPOINTS = 64

DIGITS = 9
"""Decimals of a waypoint [m]."""


@dataclass(frozen=True)
class Motion:
    """Where a region is, seen from where it begins.

    Attributes:
        steps: Of the waypoints, at least two, increasing.
        offsets: From where the region begins to each waypoint [m]; the first one is zero.
        endless: Whether it goes on beyond the last waypoint as it came there.
    """

    steps: tuple[int, ...]
    offsets: tuple[tuple[float, ...], ...]
    endless: bool = False

    @property
    def velocity(self) -> tuple[float, ...] | None:
        """Metres a step along each axis, of a path that never ends."""
        return self.offsets[-1] if self.endless else None

    @property
    def dimension(self) -> int:
        """Dimension d of the space: 2 or 3."""
        return len(self.offsets[0])

    @property
    def speed(self) -> float:
        """Most that the region moves in a step [m]."""
        moves = np.diff(np.array(self.offsets), axis=0)
        return float((np.linalg.norm(moves, axis=1) / np.diff(self.steps)).max())

    def offset(self, steps: Any) -> np.ndarray:
        """Offsets [..., d] at steps [...], which need not be whole numbers [m]."""
        steps = np.asarray(steps, float)
        if self.endless:
            return np.maximum(steps, 0.0)[..., None] * np.array(self.offsets[-1])
        axes = np.array(self.offsets).T
        return np.stack([np.interp(steps, self.steps, axis) for axis in axes], axis=-1)

    def mirrored(self, sign: np.ndarray) -> "Motion":
        """The motion with its coordinates multiplied by 1 or -1 [d]."""
        offsets = tuple(tuple((sign * offset + 0.0).tolist()) for offset in self.offsets)
        return Motion(self.steps, offsets, self.endless)

    def waypoints(self, center: Sequence[float]) -> list[tuple[int, tuple[float, ...]]]:
        """Steps and positions [d] of a region that begins at a centre [m]."""
        positions = np.round(np.add(center, self.offsets), DIGITS + 3)
        return list(zip(self.steps, map(tuple, positions.tolist()), strict=True))


def along(velocity: Any, dimension: int) -> Motion:
    """The motion of a velocity [m per step].

    Raises:
        SceneError: not one number for each axis.
    """
    field = f"velocity: {velocity!r}"
    if not isinstance(velocity, list | tuple) or not all(map(_is_number, velocity)):
        raise SceneError(f"{field} must be a list of finite numbers, metres a step along each axis")
    if len(velocity) != dimension:
        raise SceneError(f"{field} has {len(velocity)} numbers; expected {dimension}, one an axis")
    if max(map(abs, velocity)) > LARGEST_COORDINATE:
        raise SceneError(f"{field} may be at most {LARGEST_COORDINATE:g} m a step along each axis")
    moved = tuple(float(value) for value in velocity)
    return Motion((0, 1), ((0.0,) * dimension, moved), endless=True)


def through(waypoints: Any, dimension: int) -> tuple[Motion, tuple[float, ...]]:
    """The motion along waypoints (step, x, y) or (step, x, y, z), and where it begins [d] [m].

    Raises:
        SceneError: fewer than two waypoints, or one that is malformed or out of order.
    """
    axes = ("x", "y", "z")[:dimension]
    expected = f"a waypoint is [step, {', '.join(axes)}]"
    if not isinstance(waypoints, list | tuple):
        raise SceneError(f"path: {waypoints!r} is not a list of waypoints; {expected}")
    if not 2 <= len(waypoints) <= MOST_WAYPOINTS:
        raise SceneError(
            f"path: {len(waypoints)} waypoints; from 2 to {MOST_WAYPOINTS} are allowed, {expected}"
        )
    steps, positions = [], []
    for number, waypoint in enumerate(waypoints):
        field = f"path[{number}]: {waypoint!r}"
        if not isinstance(waypoint, list | tuple) or not all(map(_is_number, waypoint)):
            raise SceneError(f"{field} is not a list of finite numbers; {expected}")
        if len(waypoint) != dimension + 1:
            raise SceneError(f"{field} has {len(waypoint)} numbers; {expected}")
        step, *position = waypoint
        if step != int(step) or not 0 <= step <= LAST_STEP:
            raise SceneError(f"{field}: the step must be an integer from 0 to {LAST_STEP:,}")
        if steps and step <= steps[-1]:
            raise SceneError(f"{field}: step {step:g} does not come after step {steps[-1]}")
        if max(map(abs, position)) > LARGEST_COORDINATE:
            raise SceneError(f"{field}: coordinates may be at most {LARGEST_COORDINATE:g} m")
        steps.append(int(step))
        positions.append(tuple(float(value) for value in position))
    offsets = np.round(np.subtract(positions, positions[0]), DIGITS) + 0.0
    return Motion(tuple(steps), tuple(map(tuple, offsets.tolist()))), positions[0]


def _is_number(value: Any) -> bool:
    return type(value) in (int, float) and math.isfinite(value)
