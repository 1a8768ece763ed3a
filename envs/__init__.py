"""Robots: one file each, one protocol, one line in `ENVS`."""

from types import MappingProxyType

from core.errors import UserError, allowed
from core.task.protocols import Tuning
from envs.ant import Ant
from envs.linear import Linear
from envs.panda import Panda
from envs.quadrotor import Quadrotor
from envs.robot import Robot, Workspace
from envs.unicycle import Unicycle

_ROBOTS: tuple[Robot, ...] = (
    Linear(),
    Unicycle(),
    Panda(),
    Quadrotor(),
    Ant(),
)

ENVS: MappingProxyType[str, Robot] = MappingProxyType({robot.name: robot for robot in _ROBOTS})
"""The robots by name."""

VARIANTS: MappingProxyType[str, tuple[str, ...]] = MappingProxyType(
    {name: tuple(robot.variants) for name, robot in ENVS.items()}
)
"""Names of the variants of each robot."""


def make_robot(name: str, variant: str = "") -> Robot:
    """A robot, or a variant of it.

    Raises:
        UserError: no such robot, or no such variant of it.
    """
    if not isinstance(name, str) or name not in ENVS:
        raise UserError(f"robot: unknown {name!r}. {allowed(name, ENVS)}")
    if variant == "":
        return ENVS[name]
    variants = ENVS[name].variants
    if not isinstance(variant, str) or variant not in variants:
        raise UserError(f"variant: unknown {variant!r} of {name!r}. {allowed(variant, variants)}")
    return variants[variant]


__all__ = [
    "ENVS",
    "VARIANTS",
    "Ant",
    "Linear",
    "Panda",
    "Quadrotor",
    "Robot",
    "Tuning",
    "Unicycle",
    "Workspace",
    "make_robot",
]
