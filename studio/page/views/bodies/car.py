"""A small car with headlights."""

from collections.abc import Mapping

import numpy as np
import viser

from envs import Unicycle
from studio.page.views.bodies.body import (
    DARK,
    LIGHT,
    PAINT,
    ROOT,
    Pose,
    plain_stage,
    rotation,
    upright,
)

AXLE = rotation(np.pi / 2, 0)
"""Turns a cylinder's axis from z to y."""

HEADING = 2
"""Index of the heading [rad] in the state."""


class Car:
    """Turns with the heading."""

    def __init__(self, robot: Unicycle) -> None:
        self.stage = plain_stage(robot.workspace.arena)

    def build(self, scene: viser.SceneApi, node: str) -> Mapping[str, viser.SceneNodeHandle]:
        """Body, cabin, lamps and wheels."""
        scene.add_box(f"{node}/body", PAINT, (0.62, 0.32, 0.14), position=(0, 0, 0.15))
        scene.add_box(f"{node}/cabin", DARK, (0.28, 0.26, 0.12), position=(-0.06, 0, 0.28))
        for i, y in enumerate((-0.1, 0.1)):
            scene.add_box(f"{node}/lamp{i}", LIGHT, (0.03, 0.07, 0.05), position=(0.31, y, 0.17))
        for i, (x, y) in enumerate(((0.19, 0.17), (0.19, -0.17), (-0.19, 0.17), (-0.19, -0.17))):
            scene.add_cylinder(
                f"{node}/wheel{i}", 0.09, 0.07, DARK, wxyz=AXLE, position=(x, y, 0.09)
            )
        return {}

    def track(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """The states."""
        del actions
        return states

    def poses(self, row: np.ndarray) -> Mapping[str, Pose]:
        """At (x, y), turned to the heading."""
        return {ROOT: upright(row[:2], float(row[HEADING]))}
