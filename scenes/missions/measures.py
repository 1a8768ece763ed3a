"""Lengths and times of a robot's missions, all from what the robot tells of itself."""

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from core.errors import UserError
from core.stl import horizon
from core.task.task import STEP_BUCKET
from envs import ENVS, Robot, make_robot
from scenes.arena import Arena, scale_of
from scenes.formula import scene_formula
from scenes.scene import load_task, task_names
from scenes.shared import shared_spacing

CROSSINGS = 4
"""Times that a robot without shipped tasks may cross its arena in a mission."""


@dataclass(frozen=True)
class Measures:
    """How large a robot's missions are.

    Attributes:
        robot: Whose missions.
        low: Low corner of the arena [d] in [m].
        high: High corner [d] in [m].
        unit: A tenth of the arena in [m], by the geometric mean of its sides.
        clearance: Distance that planned ways keep from obstacles in [m].
        tight: Half the width in [m] of a gap that the robot barely passes: the planned way keeps
            its clearance, and a node of the grid lies between.
        wide: Half the width in [m] of a gap that is no obstacle to this robot.
        speed: Planning speed in [m/step].
        lag: Steps that a leg may need on top of its distance.
        steps: Largest horizon of a mission.
        arena: Of its scene; None for the robot's own.
    """

    robot: str
    low: tuple[float, ...]
    high: tuple[float, ...]
    unit: float
    clearance: float
    tight: float
    wide: float
    speed: float
    lag: float
    steps: int
    arena: Arena | None = None

    @property
    def dimension(self) -> int:
        """Of the space: 2 or 3."""
        return len(self.low)

    @property
    def crossings(self) -> float:
        """Times that the robot crosses its arena in a mission."""
        longest = max(high - low for low, high in zip(self.low, self.high, strict=True))
        return self.steps / self.travel(longest)

    @property
    def keep(self) -> float:
        """Distance in [m] that goals and starts keep from obstacles."""
        return 1.2 * self.clearance

    def travel(self, distance: float) -> float:
        """Steps for a way of a length in [m]."""
        return distance / self.speed + self.lag


@cache
def measures(robot_name: str) -> Measures:
    """The measures of a robot by name.

    Raises:
        UserError: no such robot.
    """
    robot = make_robot(robot_name)
    workspace = robot.workspace
    low, high = np.array(workspace.arena, float).T
    unit = float(np.prod(high - low) ** (1 / low.size)) / 10
    tight = workspace.clearance + workspace.spacing / 2
    return Measures(
        robot=robot_name,
        low=tuple(low.tolist()),
        high=tuple(high.tolist()),
        unit=unit,
        clearance=workspace.clearance,
        tight=tight,
        wide=tight + 0.8 * unit + 0.3 * robot.lag * robot.speed,
        speed=robot.speed,
        lag=robot.lag,
        steps=mission_steps(robot_name),
    )


def measures_in(robot_name: str, arena: Arena | None) -> Measures:
    """The measures of a robot in an arena of its own.

    Where the arena is smaller than the robot's, gaps and clearances do not shrink with it: the
    robot moves as far in a step.

    Raises:
        UserError: no such robot.
    """
    own = measures(robot_name)
    if arena is None:
        return own
    robot = make_robot(robot_name)
    scale = scale_of(robot.workspace, arena)
    clearance = max(scale, 1.0) * own.clearance
    tight = max(own.tight, clearance + shared_spacing(robot.workspace, arena) / 2)
    low, high = np.array(arena, float).T
    return replace(
        own,
        low=tuple(low.tolist()),
        high=tuple(high.tolist()),
        unit=scale * own.unit,
        clearance=clearance,
        tight=tight,
        wide=tight + 0.8 * scale * own.unit + 0.3 * robot.lag * robot.speed,
        arena=arena,
    )


@cache
def mission_steps(robot_name: str) -> int:
    """The largest horizon of a robot's missions: that of its shipped tasks, padded [steps]."""
    robot = make_robot(robot_name)
    longest = _shipped_horizon(robot)
    if longest == 0:
        sides = [high - low for low, high in robot.workspace.arena]
        longest = int(CROSSINGS * (max(sides) / robot.speed + robot.lag))
    return -(-longest // STEP_BUCKET) * STEP_BUCKET


def _shipped_horizon(robot: Robot) -> int:
    """Longest horizon of the robot's shipped tasks [steps]; 0 if there are none."""
    longest = 0
    try:
        names = task_names(robot.name) if robot.name in ENVS else []
    except UserError:
        names = []
    for name in names:
        scene = load_task(name)
        longest = max(longest, scene.horizon, horizon(scene_formula(scene)))
    return longest
