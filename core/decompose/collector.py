"""Collects variables, tasks and requirements, with names, and within limits."""

from typing import Literal, NamedTuple

from core.decompose.model import (
    DecompositionError,
    Guards,
    Kind,
    Requirement,
    Subtask,
    TimeExpr,
    TreeNode,
    Variable,
)
from core.stl import Atom, Formula, Interval, Not, to_text, walk

MOST_VARIABLES = 100
"""Far more than any schedule can have; nested chains of visits stop growing here."""

MOST_TASKS = 1000
"""Visits to conjunctions have a task for each part."""

MOST_NODES = 10_000
"""Names and operators in the predicates of all tasks; a visit repeats its whole operand."""


class Window(NamedTuple):
    """The steps from `start` to `end`; empty where start > end."""

    start: TimeExpr
    end: TimeExpr


class Collector:
    """What the rules have found so far, left to right."""

    def __init__(self) -> None:
        self.variables: list[Variable] = []
        self.tasks: list[Subtask] = []
        self.requirements: list[Requirement] = []
        self._nodes = 0

    def reach(self, predicate: Formula, time: TimeExpr, guards: Guards) -> TreeNode:
        """Add Reach(predicate, time)."""
        index = self._add(Subtask(Kind.REACH, predicate, time, time, guards, predicate), predicate)
        label = f"Reach({to_text(predicate)}, {time.text(self.variables)})"
        return TreeNode(label, predicate, index, time=time)

    def invariance(
        self, predicate: Formula, window: Window, guards: Guards, source: Formula
    ) -> TreeNode:
        """Add Inv(predicate, window): a stay, or an invariant constraint.

        It is a constraint if it negates, or if it speaks of the state from step 0 on: nobody
        travels to a speed.
        """
        negates = any(isinstance(node, Not) for node in walk(predicate))
        of_state = any(isinstance(node, Atom) and not node.place for node in walk(predicate))
        constrains = negates or (of_state and window.start == TimeExpr())
        kind = Kind.INVARIANT if constrains else Kind.STAY
        index = self._add(Subtask(kind, predicate, *window, guards, source), source)
        start, end = (time.text(self.variables) for time in window)
        label = f"Inv({to_text(predicate)}, [{start}, {end}])"
        return TreeNode(label, predicate, index, time=window.start)

    def time_variable(self, domain: Interval, source: Formula, guards: Guards) -> int:
        """Add a time in a domain [steps]; returns its index."""
        return self._variable("time", domain, (), source, guards)

    def branch_variable(self, labels: tuple[str, ...], source: Formula, guards: Guards) -> int:
        """Add a choice between labelled alternatives; returns its index."""
        return self._variable("branch", Interval(0, len(labels) - 1), labels, source, guards)

    def require(
        self,
        later: TimeExpr,
        since: TimeExpr,
        guards: Guards,
        *,
        minimum: int | None = None,
        maximum: int | None = None,
    ) -> None:
        """Require minimum <= later - since <= maximum, unless the domains imply it."""
        low, high = self.difference(later, since)
        offset, plus, minus = _difference(later, since)
        if minimum is not None:
            minimum = None if minimum <= low else minimum - offset
        if maximum is not None:
            maximum = None if maximum >= high else maximum - offset
        if minimum is not None or maximum is not None:
            total, since = TimeExpr(0, plus), TimeExpr(0, minus)
            self.requirements.append(Requirement(total, minimum, guards, maximum, since))

    def difference(self, later: TimeExpr, since: TimeExpr) -> Interval:
        """Least and largest value of later - since over the domains."""
        offset, plus, minus = _difference(later, since)
        added, taken = ([self.variables[i] for i in indices] for indices in (plus, minus))
        least = offset + sum(v.low for v in added) - sum(v.high for v in taken)
        most = offset + sum(v.high for v in added) - sum(v.low for v in taken)
        return Interval(least, most)

    def check_variables(self, more: int, source: Formula) -> None:
        """Refuse so many further variables if there would be too many."""
        needed = len(self.variables) + more
        if needed > MOST_VARIABLES:
            raise DecompositionError(
                source, f"it needs {needed:,} variables or more; at most {MOST_VARIABLES} are tried"
            )

    def _variable(
        self,
        kind: Literal["time", "branch"],
        domain: Interval,
        labels: tuple[str, ...],
        source: Formula,
        guards: Guards,
    ) -> int:
        self.check_variables(1, source)
        number = 1 + sum(variable.kind == kind for variable in self.variables)
        name = f"{'t' if kind == 'time' else 'b'}{number}"
        self.variables.append(Variable(name, *domain, kind, labels, source, guards))
        return len(self.variables) - 1

    def _add(self, task: Subtask, source: Formula) -> int:
        """Add a task; returns its index."""
        if len(self.tasks) == MOST_TASKS:
            raise DecompositionError(source, f"it needs more than {MOST_TASKS:,} tasks")
        self._nodes += sum(1 for _ in walk(task.predicate))
        if self._nodes > MOST_NODES:
            raise DecompositionError(
                source, f"its tasks together have more than {MOST_NODES:,} names and operators"
            )
        self.tasks.append(task)
        return len(self.tasks) - 1


def _difference(later: TimeExpr, since: TimeExpr) -> tuple[int, tuple[int, ...], tuple[int, ...]]:
    """Offset of later - since, and the variables that it adds and takes away."""
    plus, minus = list(later.variables), list(since.variables)
    for variable in since.variables:
        if variable in plus:
            plus.remove(variable)
            minus.remove(variable)
    return later.offset - since.offset, tuple(plus), tuple(minus)
