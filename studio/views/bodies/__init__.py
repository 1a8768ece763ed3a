"""What the robots look like, and what they stand on; one file a robot."""

from types import MappingProxyType

from studio.views.bodies.arm import Arm
from studio.views.bodies.ball import Ball
from studio.views.bodies.body import Body, Camera, Pose, Stage
from studio.views.bodies.car import Car
from studio.views.bodies.multirotor import Multirotor
from studio.views.bodies.spider import Spider

BODIES: MappingProxyType[str, Body] = MappingProxyType(
    {
        "linear": Ball(),
        "unicycle": Car(),
        "panda": Arm(),
        "quadrotor": Multirotor(),
        "ant": Spider(),
    }
)
"""By the robot's name."""

__all__ = ["BODIES", "Body", "Camera", "Pose", "Stage"]
