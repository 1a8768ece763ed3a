"""A ball: for robots without a heading, and for those that bring no body of their own."""

from collections.abc import Mapping
from functools import cache

import jax
import numpy as np
import viser

from envs import Robot
from studio.page.views.bodies.body import (
    DARK,
    PAINT,
    ROOT,
    Pose,
    plain_stage,
    upright,
)


class Ball:
    """Where the robot is: on a dark foot on the floor, or afloat in space.

    Its radius is the distance that planned ways keep from obstacles.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self.stage = plain_stage(robot.workspace.arena)

    def build(self, scene: viser.SceneApi, node: str) -> Mapping[str, viser.SceneNodeHandle]:
        """Foot and ball."""
        radius, planar = self._robot.workspace.clearance, self._robot.position_size == 2
        height = 1.25 * radius if planar else 0.0
        if planar:
            low = (0, 0, 0.2 * radius)
            scene.add_cylinder(f"{node}/foot", 1.25 * radius, 0.25 * radius, DARK, position=low)
        scene.add_icosphere(f"{node}/ball", radius, PAINT, subdivisions=4, position=(0, 0, height))
        return {}

    def track(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """The states."""
        del actions
        return states

    def poses(self, row: np.ndarray) -> Mapping[str, Pose]:
        """Upright at the robot's position."""
        return {ROOT: upright(np.asarray(_position(self._robot)(row)))}


@cache
def _position(robot: Robot):
    return jax.jit(robot.position)
