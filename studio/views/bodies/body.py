"""What a robot's look consists of: a stage, solids below a node, and poses from states.

The scene's z points up. A body says where its parts are; views set the nodes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import viser

Color = tuple[int, int, int]

PAINT, DARK, LIGHT = (247, 103, 7), (52, 58, 64), (255, 243, 191)
FLOOR, GRID = (247, 248, 250), (226, 229, 234)

ROOT = ""
"""The part that carries all others."""


class Pose(NamedTuple):
    """Of a part in the frame of the node above it."""

    position: np.ndarray  # [3] in [m]
    wxyz: np.ndarray  # [4], a unit quaternion


@dataclass(frozen=True)
class Camera:
    """Where a robot's workspace is seen from at first.

    Attributes:
        position: of the eye in [m].
        look_at: point in the middle of the picture in [m].
        fov: vertical field of view in [rad].
    """

    position: tuple[float, float, float]
    look_at: tuple[float, float, float]
    fov: float = 0.8


@dataclass(frozen=True)
class Stage:
    """What a robot stands on, at z = 0.

    Attributes:
        floor: (low, high) of x and y in [m].
        camera: the first view.
        cell: of the grid in [m].
        color: of the floor.
        grid: colour of its lines.
        thickness: of the floor in [m].
        rim: colour of a low wall on the floor's edge; None for none.
    """

    floor: tuple[tuple[float, float], tuple[float, float]]
    camera: Camera
    cell: float = 1.0
    color: Color = FLOOR
    grid: Color = GRID
    thickness: float = 0.1
    rim: Color | None = None


ARENA = ((-5.0, 5.0), (-5.0, 5.0))
"""Floor of the robots that move about [m]."""

OVERHEAD = Camera((0.0, -13.0, 15.8), (0.0, -1.9, 0.0))
"""View of the arena from the south, low enough for a panel below it."""


class Body(Protocol):
    """A robot's look. Stateless: one value serves all pages."""

    @property
    def stage(self) -> Stage:
        """What the robot stands on and is seen from."""
        ...

    def build(self, scene: viser.SceneApi, node: str) -> Mapping[str, viser.SceneNodeHandle]:
        """Add the solids below a node; returns the parts that move against it, by name."""
        ...

    def track(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """What is posed at each step of a rollout [T + 1, k], states [T + 1, n] at the front.

        Args:
            states: [T + 1, n].
            actions: [T, m] as the policy gave them.
        """
        ...

    def poses(self, row: np.ndarray) -> Mapping[str, Pose]:
        """Poses of `ROOT` and of the moving parts, of a row [k] of the track or a state [n]."""
        ...


def rotation(angle: float, axis: int) -> np.ndarray:
    """Unit quaternion [4] of a turn by an angle [rad] about x (0), y (1) or z (2)."""
    turn = np.zeros(4)
    turn[0], turn[1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return turn


def upright(position: np.ndarray, heading: float = 0.0) -> Pose:
    """Pose of what stands at a position [2] or [3] and looks along a heading [rad]."""
    return Pose(np.concatenate([position, np.zeros(3)])[:3], rotation(heading, 2))
