"""A task: a formula grounded in a robot's world."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from core.grounding import Grounding
from core.problem import Problem
from core.protocols import Robot, World
from core.stl import Formula


@dataclass(frozen=True, eq=False)
class Layouts:
    """Other layouts of a task, for learning what holds in all of them."""

    training: Callable[[int], Problem]
    """The n-th layout to learn on, always the same one."""
    held_out: tuple[Problem, ...]
    """Layouts that are only evaluated on."""


@dataclass(frozen=True, eq=False)
class Task:
    """What training, evaluation and the page work on."""

    name: str
    robot: Robot
    world: World
    grounding: Grounding
    problem: Problem
    layouts: Layouts | None = None

    @property
    def formula(self) -> Formula:
        """The formula that decides success."""
        return self.grounding.decomposition.formula

    @property
    def horizon(self) -> int:
        """Steps of an episode: max(T, horizon of the formula)."""
        return self.grounding.steps

    @cached_property
    def steps(self) -> int:
        """Steps that programs are compiled for: the horizon rounded up.

        Rounding lets formulas of nearly the same horizon share their compiled programs.
        """
        return -(-self.horizon // STEP_BUCKET) * STEP_BUCKET


STEP_BUCKET = 16
"""Horizons are rounded up to a multiple of this many steps."""
