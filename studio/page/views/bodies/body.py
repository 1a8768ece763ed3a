"""A robot's appearance: a stage, solids below a node, and poses from states.

The scene's z axis points up. A body gives the poses of its parts; views set the nodes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple, Protocol

import numpy as np
import viser

Color = tuple[int, int, int]

PAINT, DARK, LIGHT = (247, 103, 7), (52, 58, 64), (255, 243, 191)
FLOOR, GRID = (247, 248, 250), (226, 229, 234)

ROOT = ""
"""The part that carries all others."""


class Pose(NamedTuple):
    """Pose of a part in the frame of its parent node."""

    position: np.ndarray  # [3] in [m]
    wxyz: np.ndarray  # [4], a unit quaternion


@dataclass(frozen=True)
class Camera:
    """The initial view of a robot's workspace.

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
        fixed: whether the robot is mounted on it, so that it stays where it is in any arena.
    """

    floor: tuple[tuple[float, float], tuple[float, float]]
    camera: Camera
    cell: float = 1.0
    color: Color = FLOOR
    grid: Color = GRID
    thickness: float = 0.1
    rim: Color | None = None
    fixed: bool = False


def plain_stage(arena: tuple[tuple[float, float], ...]) -> Stage:
    """A floor below an arena ((low, high) [m] of each axis), seen whole from the south.

    The camera stands low enough for a panel below the floor, and higher over a hall than over a
    plane.
    """
    floor = (arena[0], arena[1])
    (left, right), (front, back) = floor
    x, y = (left + right) / 2, (front + back) / 2
    unit = max(right - left, back - front) / 10
    top = arena[2][1] if len(arena) > 2 else 0.0
    camera = Camera((x, y - 13.0 * unit - top, 15.8 * unit + top), (x, y - 1.9 * unit, 0.0))
    return Stage(floor, camera, cell=float(10.0 ** np.floor(np.log10(2 * unit))))


def fitted_stage(stage: Stage, arena: tuple[tuple[float, float], ...]) -> Stage:
    """A robot's stage in another arena than its own; a table grows where the arena leaves it."""
    if stage.fixed:
        pairs = zip(stage.floor, arena, strict=False)
        x, y = ((min(low, least), max(high, most)) for (low, high), (least, most) in pairs)
        return replace(stage, floor=(x, y))
    plain = plain_stage(arena)
    return replace(stage, floor=plain.floor, camera=plain.camera, cell=plain.cell)


class Body(Protocol):
    """A robot's appearance. Stateless: one value serves all pages."""

    @property
    def stage(self) -> Stage:
        """What the robot stands on, and its camera."""
        ...

    def build(self, scene: viser.SceneApi, node: str) -> Mapping[str, viser.SceneNodeHandle]:
        """Add the solids below a node; returns the parts that move relative to it, by name."""
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
    """Upright pose at a position [2] or [3] with a heading [rad]."""
    return Pose(np.concatenate([position, np.zeros(3)])[:3], rotation(heading, 2))
