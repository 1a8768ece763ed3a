"""What the robots look like: solids below a node that carries the robot's pose.

x points forward, z up; the node's origin is the robot's position on the floor.
"""

import math
from collections.abc import Callable
from types import MappingProxyType

import viser

PAINT, DARK, LIGHT = (247, 103, 7), (52, 58, 64), (255, 243, 191)
AXLE = (math.cos(math.pi / 4), math.sin(math.pi / 4), 0.0, 0.0)
"""Turns a cylinder's axis from z to y."""


def add_ball(scene: viser.SceneApi, node: str) -> None:
    """A ball on a dark foot, for a robot without a heading."""
    scene.add_cylinder(f"{node}/foot", 0.2, 0.04, DARK, position=(0, 0, 0.03))
    scene.add_icosphere(f"{node}/ball", 0.16, PAINT, subdivisions=4, position=(0, 0, 0.2))


def add_car(scene: viser.SceneApi, node: str) -> None:
    """A small car with its lamps in front."""
    scene.add_box(f"{node}/body", PAINT, (0.62, 0.32, 0.14), position=(0, 0, 0.15))
    scene.add_box(f"{node}/cabin", DARK, (0.28, 0.26, 0.12), position=(-0.06, 0, 0.28))
    for i, y in enumerate((-0.1, 0.1)):
        scene.add_box(f"{node}/lamp{i}", LIGHT, (0.03, 0.07, 0.05), position=(0.31, y, 0.17))
    for i, (x, y) in enumerate(((0.19, 0.17), (0.19, -0.17), (-0.19, 0.17), (-0.19, -0.17))):
        scene.add_cylinder(f"{node}/wheel{i}", 0.09, 0.07, DARK, wxyz=AXLE, position=(x, y, 0.09))


BODY: MappingProxyType[str, Callable[[viser.SceneApi, str], None]] = MappingProxyType(
    {"linear": add_ball, "unicycle": add_car}
)
"""By the robot's name."""

HEADING: MappingProxyType[str, int] = MappingProxyType({"unicycle": 2})
"""Index of the heading [rad] in the states of robots that have one."""
