"""What a formula decomposes into: variables, tasks with windows, requirements, and the tree.

A *schedule* assigns an integer to every variable, in the order of `Decomposition.variables`.
Times are in steps. A formula is reduced to tasks (paper Sec. 4.1)

    Reach(mu, tau):       mu holds at step tau,
    Inv(mu, [t1, t2]):    mu holds at every step of the closed window [t1, t2],

whose windows are sums of variables and a constant. A task counts only in the branches that its
guards name; an empty window (start > end) holds vacuously.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum
from itertools import product
from typing import Literal

import numpy as np

from core.errors import UserError
from core.quoting import LONGEST_FORMULA, shown
from core.stl import Formula, to_text

Guards = tuple[tuple[int, int], ...]
"""(index of a branch variable, value that it must have); all must match."""


class DecompositionError(UserError):
    """A subformula that the rules of decomposition do not cover."""

    def __init__(self, formula: Formula, reason: str, *, near: Formula | None = None):
        self.formula = formula
        self.reason = reason
        self.span = formula.span or (near.span if near else None)
        place = f" (columns {self.span.start + 1}-{self.span.stop})" if self.span else ""
        text = shown(to_text(formula), LONGEST_FORMULA)
        super().__init__(f"cannot decompose `{text}`{place}: {reason}")


@dataclass(frozen=True)
class Variable:
    """An unknown of the schedule: a time in [low, high] steps, or the choice of a branch."""

    name: str
    low: int
    high: int
    kind: Literal["time", "branch"]
    labels: tuple[str, ...]
    """Text of the alternatives, one for each value (branches only)."""
    source: Formula
    guards: Guards = ()
    """Where they do not match, the value of the variable has no effect."""


@dataclass(frozen=True)
class TimeExpr:
    """The step offset + sum of schedule[i] over `variables`."""

    offset: int = 0
    variables: tuple[int, ...] = ()

    def at(self, schedule: Sequence[int]) -> int:
        """Value under a schedule [steps]."""
        return self.offset + sum(schedule[i] for i in self.variables)

    def plus(self, steps: int, *variables: int) -> "TimeExpr":
        """Add a number of steps and further variables."""
        return TimeExpr(self.offset + steps, self.variables + variables)

    def text(self, variables: Sequence[Variable]) -> str:
        """As a person writes it: `t1 + t2 + 5`."""
        if not self.variables:
            return str(self.offset)
        total = " + ".join(variables[i].name for i in self.variables)
        if self.offset == 0:
            return total
        return f"{total} {'+' if self.offset > 0 else '-'} {abs(self.offset)}"


class Kind(Enum):
    """Role of a task: the first two are subgoals, the third is an invariant constraint."""

    REACH = "reach"
    STAY = "stay"
    INVARIANT = "invariant"


@dataclass(frozen=True)
class Subtask:
    """`predicate`, a state formula in negation normal form, holds throughout [start, end]."""

    kind: Kind
    predicate: Formula
    start: TimeExpr
    end: TimeExpr
    guards: Guards = ()
    source: Formula | None = None
    """The subformula whose rule ended in this task."""


@dataclass(frozen=True)
class Requirement:
    """A schedule is admissible only if minimum <= total - since <= maximum, where guards match."""

    total: TimeExpr
    minimum: int | None
    guards: Guards = ()
    maximum: int | None = None
    since: TimeExpr = TimeExpr()

    def met(self, schedule: Sequence[int]) -> bool:
        """Whether a schedule keeps the bounds, guards apart."""
        value = self.total.at(schedule) - self.since.at(schedule)
        above = self.minimum is None or value >= self.minimum
        return above and (self.maximum is None or value <= self.maximum)


@dataclass(frozen=True)
class TreeNode:
    """A node of the drawing of the decomposition, as in the paper's Fig. 2.

    The edge to the node carries `variable` (an index) when the node introduces it, and for a
    branch variable also the value `choice` that leads here. Leaves carry the index of their task.
    """

    label: str
    formula: Formula
    task: int | None = None
    variable: int | None = None
    children: tuple["TreeNode", ...] = ()
    choice: int | None = None
    time: TimeExpr = field(default_factory=TimeExpr)
    end: TimeExpr | None = None
    """Last step of the window throughout which the formula holds; None for one step."""

    def walk(self) -> Iterator["TreeNode"]:
        """Yield the node and all below it, parents first."""
        yield self
        for child in self.children:
            yield from child.walk()


@dataclass(frozen=True)
class Decomposition:
    """Tasks, and the schedules under which fulfilling all active tasks satisfies the formula."""

    formula: Formula
    variables: tuple[Variable, ...]
    tasks: tuple[Subtask, ...]
    requirements: tuple[Requirement, ...]
    tree: TreeNode
    horizon: int
    """Last step that the formula looks at."""
    names: tuple[tuple[str, Formula], ...] = ()
    """Short names of the subformulas in the labels of the tree, the formula itself first."""
    visits_missing: int = 0
    """How many further visits in each chain make "only if" true; 0 if they cannot or it is."""
    visits_extra: int = 0
    """Visits in each chain beyond the least number that can work."""
    one_sided: bool = False
    """Whether some satisfying traces fit no schedule, however many visits there are."""

    def own_values(self, schedule: Sequence[int] | np.ndarray) -> tuple[int, ...]:
        """The values of a schedule without its padding."""
        return tuple(int(value) for value in schedule[: len(self.variables)])

    def schedules(self) -> Iterator[tuple[int, ...]]:
        """Every admissible schedule, in lexicographic order."""
        domains = (range(v.low, v.high + 1) for v in self.variables)
        return (schedule for schedule in product(*domains) if self.admissible(schedule))

    def admissible(self, schedule: Sequence[int]) -> bool:
        """Whether the values lie in their domains and the active requirements are met."""
        in_domain = len(schedule) == len(self.variables) and all(
            v.low <= value <= v.high for v, value in zip(self.variables, schedule, strict=True)
        )
        return in_domain and all(
            requirement.met(schedule)
            for requirement in self.requirements
            if _matches(requirement.guards, schedule)
        )

    def active_tasks(self, schedule: Sequence[int]) -> list[tuple[Subtask, int, int]]:
        """Tasks of the chosen branches with first and last step, empty windows included."""
        return [
            (task, task.start.at(schedule), task.end.at(schedule))
            for task in self.tasks
            if _matches(task.guards, schedule)
        ]


def _matches(guards: Guards, schedule: Sequence[int]) -> bool:
    return all(schedule[variable] == value for variable, value in guards)
