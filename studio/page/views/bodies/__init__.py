"""What the robots look like, and what they stand on; one file a body."""

from collections.abc import Callable
from functools import cache
from types import MappingProxyType
from typing import Any

from envs import Robot
from scenes import Scene, robot_of, workspace_of
from studio.page.views.bodies.arm import Arm
from studio.page.views.bodies.ball import Ball
from studio.page.views.bodies.body import Body, Camera, Pose, Stage, fitted_stage
from studio.page.views.bodies.car import Car
from studio.page.views.bodies.multirotor import Multirotor
from studio.page.views.bodies.spider import Spider

BODIES: MappingProxyType[str, Callable[[Any], Body]] = MappingProxyType(
    {"ball": Ball, "car": Car, "arm": Arm, "multirotor": Multirotor, "spider": Spider}
)
"""What makes the body of a robot, by the name that the robot gives in `drawn_as`."""


@cache
def body_of(robot: Robot) -> Body:
    """The body of a robot; a plain ball where its name is not one of `BODIES`."""
    return BODIES.get(robot.drawn_as, Ball)(robot)


def stage_of(scene: Scene) -> Stage:
    """What the robot of a scene stands on, in the scene's arena."""
    robot = robot_of(scene)
    stage, arena = body_of(robot).stage, workspace_of(scene).arena
    return stage if arena == robot.workspace.arena else fitted_stage(stage, arena)


__all__ = ["BODIES", "Body", "Camera", "Pose", "Stage", "body_of", "stage_of"]
