"""What every trace that satisfies a formula must do, for any formula.

A formula is reduced, top-down as in `core.decompose`, to *holds*: a state formula holds
throughout a window whose ends are instants, an instant being an unknown step plus a number.
Where the decomposition needs a choice at every step of a window, here only some steps are looked
at. So every satisfying trace meets the obligations; not every trace that meets them satisfies.

At an instant e:

    mu                        mu holds at e
    phi1 & phi2               both                        phi1 | phi2     a choice
    F_[a:b] phi               an instant in [e+a, e+b]; phi there
    G_[a:b] phi               phi throughout [e+a, e+b]
    phi1 U_[a:b] phi2         an instant t in [e+a, e+b]; phi2 there; phi1 throughout [e, t]
    !(phi1 U_[a:b] phi2)      a choice: !phi2 throughout [e+a, e+b]; or an instant s in [e, e+b],
                              !phi1 there, !phi2 throughout [e+a, s-1]

Throughout a window: a state formula holds there, a conjunction does part by part, G widens the
window, F_[c:d] is asked of steps c apart by its own width, anything else of the window's ends.
"""

from dataclasses import dataclass, field
from itertools import islice
from typing import NamedTuple

from core.stl import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Interval,
    Not,
    Or,
    Until,
    fold_constants,
    is_state_formula,
    negation_normal_form,
    walk,
)

MOST_HOLDS = 48
"""Further obligations are left out."""

MOST_INSTANTS = 24

MOST_CHOICES = 16

MOST_NODES = 60
"""Names and operators of a state formula; a larger one is left out."""

MOST_REPEATS = 8
"""Steps of a window at which F is asked for."""


Scope = tuple[tuple[int, int], ...]
"""Alternatives that were chosen, one within the other: (number of the choice, alternative)."""


class Instant(NamedTuple):
    """The step of a node plus an offset; node 0 is step 0."""

    node: int = 0
    offset: int = 0

    def plus(self, steps: int) -> "Instant":
        """Some steps later."""
        return Instant(self.node, self.offset + steps)


@dataclass(frozen=True)
class Node:
    """An unknown step, from `low` to `high` steps after an instant."""

    after: Instant
    low: int
    high: int
    source: Formula


@dataclass(frozen=True)
class Hold:
    """A state formula in negation normal form that holds throughout [start, end]."""

    predicate: Formula
    start: Instant
    end: Instant
    source: Formula
    """The temporal formula that asks for it, or the state formula itself."""
    scope: Scope = ()
    """Alternatives within which it counts."""


@dataclass(frozen=True)
class Choice:
    """Alternatives, one of which must be met: their holds carry its number in their scopes."""

    scope: Scope
    alternatives: tuple[Formula, ...]


@dataclass
class Obligations:
    """Of a formula: unknown steps, holds and choices."""

    nodes: list[Node] = field(default_factory=list)
    """Node i + 1 is the i-th."""
    holds: list[Hold] = field(default_factory=list)
    choices: list[Choice] = field(default_factory=list)


def obligations_of(formula: Formula, start: Formula) -> Obligations:
    """Obligations of a formula; the first hold is that the robot begins in a place.

    Args:
        formula: any formula.
        start: a state formula of where episodes begin.
    """
    builder = _Builder()
    origin = Instant()
    builder.hold(start, origin, origin, start, ())
    normal = negation_normal_form(fold_constants(formula))
    if not isinstance(normal, Constant):
        builder.at(normal, origin, ())
    return builder.found


class _Builder:
    def __init__(self) -> None:
        self.found = Obligations()

    def at(self, formula: Formula, e: Instant, scope: Scope) -> None:
        """The formula at an instant."""
        if self._full():
            return
        if is_state_formula(formula):
            self.hold(formula, e, e, formula, scope)
            return
        match formula:
            case And(operands=operands):
                for operand in operands:
                    self.at(operand, e, scope)
            case Or(operands=operands):
                for inner, operand in zip(self._choose(operands, scope), operands, strict=True):
                    self.at(operand, e, inner)
            case Eventually(interval=interval, operand=operand):
                if (t := self._instant(e, interval, formula)) is not None:
                    self.at(operand, t, scope)
            case Always(interval=(a, b), operand=operand):
                self.throughout(operand, e.plus(a), e.plus(b), formula, scope)
            case Until(interval=interval, left=left, right=right):
                if (t := self._instant(e, interval, formula)) is not None:
                    self.at(right, t, scope)
                    self.throughout(left, e, t, formula, scope)
            case Not(operand=Until() as until):
                self._negated_until(until, e, formula, scope)

    def throughout(
        self, formula: Formula, s: Instant, e: Instant, source: Formula, scope: Scope
    ) -> None:
        """The formula at every step of a window [s, e] that is not empty."""
        if is_state_formula(formula):
            self.hold(formula, s, e, source, scope)
            return
        match formula:
            case And(operands=operands):
                for operand in operands:
                    self.throughout(operand, s, e, source, scope)
            case Always(interval=(a, b), operand=operand):
                self.throughout(operand, s.plus(a), e.plus(b), source, scope)
            case Eventually(interval=(a, b), operand=operand) if a == b:
                self.throughout(operand, s.plus(a), e.plus(a), source, scope)
            case _:
                for instant in _repeats(formula, s, e):
                    self.at(formula, instant, scope)

    def hold(
        self, predicate: Formula, s: Instant, e: Instant, source: Formula, scope: Scope
    ) -> None:
        """Add a hold while there is room, and its state formula is of a size that people write."""
        size = sum(1 for _ in islice(walk(predicate), MOST_NODES + 1))
        if not self._full() and size <= MOST_NODES:
            self.found.holds.append(Hold(predicate, s, e, source, scope))

    def _full(self) -> bool:
        found = self.found
        return len(found.holds) >= MOST_HOLDS or len(found.choices) >= MOST_CHOICES

    def _negated_until(self, until: Until, e: Instant, source: Formula, scope: Scope) -> None:
        a, b = until.interval
        fails = negation_normal_form(Not(until.left))
        never = negation_normal_form(Not(until.right))
        labels = Always(until.interval, never), Eventually(Interval(0, b), fails)
        first, second = self._choose(labels, scope)
        self.throughout(never, e.plus(a), e.plus(b), source, first)
        if (s := self._instant(e, Interval(0, b), source)) is not None:
            self.at(fails, s, second)
            if is_state_formula(never):  # the window may be empty
                self.hold(never, e.plus(a), s.plus(-1), source, second)

    def _choose(self, alternatives: tuple[Formula, ...], scope: Scope) -> list[Scope]:
        """Scopes of the alternatives of a new choice."""
        self.found.choices.append(Choice(scope, alternatives))
        number = len(self.found.choices) - 1
        return [(*scope, (number, value)) for value in range(len(alternatives))]

    def _instant(self, e: Instant, interval: Interval, source: Formula) -> Instant | None:
        """A new instant in e + [a, b]; None if there are too many."""
        if len(self.found.nodes) >= MOST_INSTANTS:
            return None
        self.found.nodes.append(Node(e, *interval, source))
        return Instant(len(self.found.nodes))


def _repeats(formula: Formula, s: Instant, e: Instant) -> list[Instant]:
    """Steps of a window at which a temporal formula is asked for."""
    if s.node != e.node:
        return [s, e]
    length, every = e.offset - s.offset, e.offset - s.offset
    if isinstance(formula, Eventually):
        every = formula.interval.stop - formula.interval.start + 1
    steps = range(0, length, max(every, 1))[:MOST_REPEATS]
    return [s.plus(step) for step in dict.fromkeys([*steps, length])]
