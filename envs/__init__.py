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

VARIANTS: MappingProxyType[str, Robot] = MappingProxyType(
    {"links": Panda(links=True), "raw-motors": Quadrotor(raw_motors=True)}
)
"""Other readings of robots, by the names that scenes give them."""


def make_robot(name: str, variant: str = "") -> Robot:
    """A robot, or a variant of it."""
    return VARIANTS[variant] if variant else ENVS[name]


__all__ = [
    "ENVS",
    "VARIANTS",
    "Ant",
    "Linear",
    "Panda",
    "Quadrotor",
    "Robot",
    "Unicycle",
    "make_robot",
]
