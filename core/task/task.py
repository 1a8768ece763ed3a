"""A task: a formula grounded in a robot's world."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from core.stl import Formula
from core.task.feasibility import Finding
from core.task.grounding import Grounding
from core.task.problem import Problem
from core.task.protocols import Robot


@dataclass(frozen=True, eq=False)
class Layouts:
    """Other problems of a robot, for a policy that solves all of them.

    They may be other layouts of one formula or other missions; all have one padded horizon.
    """

    training: Callable[[int], Problem]
    """The n-th problem to learn on, always the same one."""
    held_out: tuple["Task", ...]
    """Tasks used for evaluation only."""


@dataclass(frozen=True, eq=False)
class Task:
    """What training, evaluation and the page work on."""

    name: str
    grounding: Grounding
    problem: Problem
    layouts: Layouts | None = None
    findings: tuple[Finding, ...] = ()
    """What stands in the way of it."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know before training, in words."""
        return tuple(finding.words for finding in self.findings)

    @property
    def robot(self) -> Robot:
        """Who carries it out."""
        return self.problem.robot

    @property
    def formula(self) -> Formula:
        """The formula that decides success."""
        return self.grounding.decomposition.formula

    @property
    def between_steps(self) -> bool:
        """Whether invariants must hold between the steps, too (see `core.between`)."""
        return self.problem.between is not None

    @property
    def predicate_names(self) -> frozenset[str]:
        """Names of the atoms that are predicates of the state, not regions."""
        if self.problem.inequalities is None:
            return frozenset()
        atoms = self.grounding.atoms
        rows = np.asarray(self.problem.inequalities.atom)
        return frozenset(atoms[row] for row in rows if row < len(atoms))

    @property
    def horizon(self) -> int:
        """Length of an episode [steps]: max(T, horizon of the formula)."""
        return self.grounding.horizon

    @cached_property
    def padded_horizon(self) -> int:
        """The horizon rounded up [steps]: the length that programs are compiled for.

        Rounding lets formulas of nearly the same horizon share their compiled programs.
        """
        return padded_steps(self.horizon)


STEP_BUCKET = 16
"""Horizons are rounded up to a multiple of this many steps."""


def padded_steps(horizon: int) -> int:
    """A horizon rounded up [steps]."""
    return -(-horizon // STEP_BUCKET) * STEP_BUCKET
