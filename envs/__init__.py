"""Robots: one file each, one protocol."""

from types import MappingProxyType

from envs.linear import Linear
from envs.robot import Robot
from envs.unicycle import Unicycle

ENVS: MappingProxyType[str, Robot] = MappingProxyType(
    {robot.name: robot for robot in (Linear(), Unicycle())}
)
"""The robots by name."""

__all__ = ["ENVS", "Linear", "Robot", "Unicycle"]
