"""A scene to begin with: one start, one goal, time enough."""

import math

import numpy as np

from envs import make_robot
from scenes.regions import Region
from scenes.scene import Scene

APART = 0.2
"""Of start and goal from the middle of the arena, as a share of its extent."""

START, GOAL = 0.4, 0.6
"""Radii in lengths of the robot."""

PATIENCE = 3.0
"""Time given over the time that the robot plans with."""


def blank(robot_name: str, variant: str = "", name: str = "new") -> Scene:
    """A mission of a robot that asks for little more than a valid file has to.

    Args:
        robot_name: one of `envs.ENVS`.
        variant: one of its variants, empty for the standard robot.
        name: of the scene.

    Raises:
        UserError: no such robot or variant.
    """
    robot = make_robot(robot_name, variant)
    low, high = np.array(robot.workspace.arena, float).T
    offset = APART * (high - low) * (np.arange(low.size) < 2)
    kind = "circle" if low.size == 2 else "sphere"

    def place(region_name: str, side: float, radius: float) -> Region:
        center = np.round((low + high) / 2 + side * offset, 3)
        size = round(radius * robot.length, 3)
        return Region(region_name, kind, tuple(center.tolist()), (size,))

    distance = 2 * float(np.linalg.norm(offset))
    steps = PATIENCE * (distance / robot.speed + robot.lag)
    horizon = 10 * math.ceil(steps / 10)
    return Scene(
        name=name,
        title=f"A new mission for {robot_name}",
        robot=robot_name,
        variant=variant,
        formula=f"F_[0:{horizon}](A1)",
        horizon=horizon,
        seed=1,
        regions=(place("A1", 1.0, GOAL),),
        initial=place("initial", -1.0, START),
    )
