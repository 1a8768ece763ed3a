"""The flags of a formula of two layers.

The fragment (Venkataraman et al. 2020; the paper's "two-layer" tasks): conjunctions and
disjunctions of F_[c:d] and G_[c:d] over conjunctions and disjunctions of F_[a:b] psi, G_[a:b] psi
and psi, the psi state formulas. One layer may be missing.

Each inner subformula has a flag z in {0, ..., w} that sums up the last w = b - a + 1 steps, all
that the subformula looks at:

    F_[a:b] psi    z' = w where psi holds, else max(0, z - 1)      met iff z > 0
    G_[a:b] psi    z' = min(w, z + 1) where psi holds, else 0      met iff z = w

It moves at the steps from a + c to b + d, which some instance of the subformula reads, and stands
still before and after.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from core.errors import UserError
from core.quoting import LONGEST_FORMULA, shown
from core.stl import (
    Always,
    And,
    Constant,
    Eventually,
    Formula,
    Interval,
    Or,
    fold_constants,
    is_state_formula,
    negation_normal_form,
    to_text,
)

NOW = Interval(0, 0)


@dataclass(frozen=True)
class Flag:
    """What is remembered of one subformula."""

    predicate: Formula
    """psi, in negation normal form."""
    always: bool
    """Whether it is a G."""
    inner: Interval
    """[a, b]."""
    outer: Interval
    """[c, d]."""

    @property
    def width(self) -> int:
        """w, steps that the subformula looks at."""
        return self.inner.stop - self.inner.start + 1

    @property
    def first(self) -> int:
        """First step that is read."""
        return self.inner.start + self.outer.start

    @property
    def last(self) -> int:
        """Last step that is read."""
        return self.inner.stop + self.outer.stop


def flags_of(formula: Formula) -> tuple[Flag, ...]:
    """The flags of a formula, each once, from left to right.

    Raises:
        UserError: the formula is not of two layers of F and G; the part at fault is named.
    """
    normal = fold_constants(negation_normal_form(formula))
    return tuple(dict.fromkeys(_outer(normal)))


def _outer(formula: Formula) -> Iterator[Flag]:
    match formula:
        case Constant():
            return
        case And(operands=operands) | Or(operands=operands) if not is_state_formula(formula):
            for operand in operands:
                yield from _outer(operand)
        case (
            Eventually(interval=interval, operand=operand)
            | Always(interval=interval, operand=operand)
        ) if not is_state_formula(operand):
            yield from _inner(operand, interval)
        case _:
            yield from _inner(formula, NOW)


def _inner(formula: Formula, outer: Interval) -> Iterator[Flag]:
    if is_state_formula(formula):
        yield Flag(formula, False, NOW, outer)
        return
    match formula:
        case And(operands=operands) | Or(operands=operands):
            for operand in operands:
                yield from _inner(operand, outer)
        case Eventually(interval=interval, operand=operand) if is_state_formula(operand):
            yield Flag(operand, False, interval, outer)
        case Always(interval=interval, operand=operand) if is_state_formula(operand):
            yield Flag(operand, True, interval, outer)
        case Eventually() | Always():
            raise _refused(formula, "holds a third layer")
        case _:
            raise _refused(formula, "is an until")


def _refused(part: Formula, why: str) -> UserError:
    text = shown(to_text(part), LONGEST_FORMULA)
    return UserError(
        f"f-mdp has flags for formulas of two layers of F and G only, but `{text}` {why}. Choose "
        "another method"
    )
