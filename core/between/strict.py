"""The strict reading of a formula: what must hold throughout a window holds between its steps, too.

A formula looks at the steps of a trace alone, so a robot may jump over a wall that it must never
enter. With psi^(k) the least value of a state formula psi from step k to step k + 1, both
included, the strict reading replaces, in negation normal form and for state formulas psi,

    G_[a:b] psi         by   G_[a:b-1] psi^                                  (psi at a if a = b)
    psi U_[a:b] phi     by   psi^ U_[a-1:b-1] G_[1:1] phi, or psi & phi at once if a = 0.

Conjunctions are taken apart first, and windows of windows joined: `G_[0:9](G_[0:5](!B) & F A)`
forbids B at every instant up to step 14. All else is asked at the steps, as before: when a goal
is reached, and what an F or an U chooses, still counts in steps. What is strictly satisfied is
satisfied.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

from core.decompose.released import released
from core.stl import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Interval,
    Not,
    Or,
    Until,
    conjunction,
    disjunction,
    fold_constants,
    is_state_formula,
    negation_normal_form,
    to_text,
    with_children,
)


class Asked(NamedTuple):
    """A state formula, and whether it is asked for from a step to the next, or at the step."""

    predicate: Formula
    throughout: bool


@dataclass(frozen=True)
class Strict:
    """A formula whose atoms stand for what is asked of a trace.

    Attributes:
        formula: In negation normal form; its atoms are the names.
        asked: What each atom stands for, by name.
    """

    formula: Formula
    asked: dict[str, Asked]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the atoms, in the order of `asked`."""
        return tuple(self.asked)

    @property
    def invariants(self) -> tuple[Formula, ...]:
        """State formulas that are asked for between steps."""
        return tuple(each.predicate for each in self.asked.values() if each.throughout)


def strict_formula(formula: Formula) -> Strict:
    """The strict reading of any formula."""
    reading = _Reading()
    found = reading.at_step(negation_normal_form(fold_constants(formula)))
    return Strict(found, reading.asked)


class _Reading:
    def __init__(self) -> None:
        self.asked: dict[str, Asked] = {}

    def at_step(self, formula: Formula) -> Formula:
        """The strict reading of a formula in normal form at a step."""
        if isinstance(formula, Constant):
            return formula
        if is_state_formula(formula):
            return self._atom(formula, throughout=False)
        match formula:
            case Always(interval=interval, operand=operand):
                return self._always(interval, operand)
            case Until(interval=interval, left=left, right=right):
                return self._until(interval, left, right)
            case Not(operand=Until() as until):
                return self.at_step(_not_until(until))
            case And(operands=operands) | Or(operands=operands):
                return with_children(formula, tuple(map(self.at_step, operands)))
            case Eventually(operand=operand):
                return replace(formula, operand=self.at_step(operand))
        raise TypeError(f"not in negation normal form: {to_text(formula)}")

    def _always(self, window: Interval, formula: Formula) -> Formula:
        """The formula throughout a window of steps and what lies between them."""
        if is_state_formula(formula) and not isinstance(formula, And):
            return self._throughout(window, formula)
        match formula:
            case And(operands=operands):
                return conjunction(self._always(window, each) for each in operands)
            case Always(interval=(a, b), operand=operand):
                return self._always(Interval(window.start + a, window.stop + b), operand)
            case Eventually(interval=(a, b), operand=operand) if a == b:
                return self._always(Interval(window.start + a, window.stop + b), operand)
            case Not(operand=Until() as until):
                return self._always(window, _not_until(until))
        return Always(window, self.at_step(formula))

    def _throughout(self, window: Interval, predicate: Formula) -> Formula:
        a, b = window
        if a == b:
            return Always(window, self._atom(predicate, throughout=False))
        return Always(Interval(a, b - 1), self._atom(predicate, throughout=True))

    def _until(self, interval: Interval, left: Formula, right: Formula) -> Formula:
        """Of the left side, the state formulas hold up to the step of the right side."""
        a, b = interval
        parts = left.operands if isinstance(left, And) else (left,)
        steady = [each for each in parts if is_state_formula(each)]
        rest = [self.at_step(each) for each in parts if not is_state_formula(each)]
        goal = self.at_step(right)
        ways = []
        if a == 0:
            held = [self._atom(each, throughout=False) for each in steady]
            ways.append(conjunction((*held, *rest, goal)))
        if b > 0:
            held = [self._atom(each, throughout=True) for each in steady]
            later = Always(Interval(1, 1), conjunction((*rest, goal)))
            ways.append(Until(Interval(max(a - 1, 0), b - 1), conjunction((*held, *rest)), later))
        return disjunction(ways)

    def _atom(self, predicate: Formula, *, throughout: bool) -> Formula:
        name = f"{'from' if throughout else 'at'} {to_text(predicate)}"
        self.asked[name] = Asked(predicate, throughout)
        return Atom(name)


def _not_until(until: Until) -> Formula:
    """A negated until as a disjunction in normal form."""
    a, b = until.interval
    if a < b:
        return released(until, None)
    fails = negation_normal_form(Not(until.left))
    never = negation_normal_form(Not(until.right))
    return disjunction((Eventually(Interval(0, a), fails), Always(Interval(a, a), never)))
