"""Robustness of subformulas at single steps, from what is known of their literals.

With the margins of a trace these are its robustness; with bounds on the margins they are bounds.
"""

from collections.abc import Callable, Iterator
from itertools import accumulate

from core.planning.reach import Literal
from core.stl import (
    Always,
    And,
    Atom,
    Eventually,
    Formula,
    Not,
    Or,
    Until,
    negation_normal_form,
)


class Values:
    """Values of formulas in negation normal form, without constants; each is worked out once."""

    def __init__(self, literal: Callable[[Formula, int], float]):
        """Take the values of literals from a function of literal and step."""
        self._literal = literal
        self._known: dict[Literal, float] = {}

    def of(self, formula: Formula, step: int) -> float:
        """Of a formula at a step [m]."""
        key = (formula, step)
        if key not in self._known:
            self._known[key] = self._made(formula, step)
        return self._known[key]

    def _made(self, formula: Formula, step: int) -> float:
        match formula:
            case Atom() | Not(operand=Atom()):
                return self._literal(formula, step)
            case And(operands=operands):
                return min(self.of(each, step) for each in operands)
            case Or(operands=operands):
                return max(self.of(each, step) for each in operands)
            case Always(interval=(a, b), operand=operand):
                return min(self.of(operand, step + k) for k in range(a, b + 1))
            case Eventually(interval=(a, b), operand=operand):
                return max(self.of(operand, step + k) for k in range(a, b + 1))
            case Until(interval=(a, b), left=left, right=right):
                held = list(accumulate((self.of(left, step + k) for k in range(b + 1)), min))
                return max(min(held[k], self.of(right, step + k)) for k in range(a, b + 1))
            case Not(operand=Until(interval=(a, b)) as until):
                fails, never = negated(until)
                failed = list(accumulate((self.of(fails, step + k) for k in range(b + 1)), max))
                return min(max(failed[k], self.of(never, step + k)) for k in range(a, b + 1))
        raise TypeError(f"not in normal form: {formula!r}")

    def supports(self, formula: Formula, step: int) -> Iterator[Literal]:
        """Literals that together give a formula its value, by the best part of each choice."""
        match formula:
            case Atom() | Not(operand=Atom()):
                yield formula, step
            case And(operands=operands):
                for each in operands:
                    yield from self.supports(each, step)
            case Or(operands=operands):
                yield from self.supports(max(operands, key=lambda f: self.of(f, step)), step)
            case Always(interval=(a, b), operand=operand):
                for k in range(a, b + 1):
                    yield from self.supports(operand, step + k)
            case Eventually(interval=(a, b), operand=operand):
                yield from self.supports(operand, self._best(operand, step + a, step + b))
            case Until():
                yield from self._of_until(formula, step)
            case Not(operand=Until() as until):
                yield from self._of_released(until, step)

    def _best(self, formula: Formula, first: int, last: int) -> int:
        return max(range(first, last + 1), key=lambda k: self.of(formula, k))

    def _of_until(self, until: Until, step: int) -> Iterator[Literal]:
        (a, b), left, right = until.interval, until.left, until.right
        held = list(accumulate((self.of(left, step + k) for k in range(b + 1)), min))
        met = max(range(a, b + 1), key=lambda k: min(held[k], self.of(right, step + k)))
        yield from self.supports(right, step + met)
        for k in range(met + 1):
            yield from self.supports(left, step + k)

    def _of_released(self, until: Until, step: int) -> Iterator[Literal]:
        a, b = until.interval
        fails, never = negated(until)
        for k in range(a, b + 1):
            best = self._best(fails, step, step + k)
            if self.of(fails, best) >= self.of(never, step + k):
                yield from self.supports(fails, best)
            else:
                yield from self.supports(never, step + k)


def negated(until: Until) -> tuple[Formula, Formula]:
    """What an until's two sides are when they do not hold, in normal form."""
    return negation_normal_form(Not(until.left)), negation_normal_form(Not(until.right))
