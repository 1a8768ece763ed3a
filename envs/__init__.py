"""Robots: one file each, one protocol."""

from types import MappingProxyType

from envs.ant import Ant
from envs.linear import Linear
from envs.panda import Panda
from envs.quadrotor import Quadrotor
from envs.robot import Robot
from envs.unicycle import Unicycle

ENVS: MappingProxyType[str, Robot] = MappingProxyType(
    {robot.name: robot for robot in (Linear(), Unicycle(), Panda(), Quadrotor(), Ant())}
)
"""The robots by name."""

__all__ = ["ENVS", "Ant", "Linear", "Panda", "Quadrotor", "Robot", "Unicycle"]
