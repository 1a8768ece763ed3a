"""What a formula asks for that nobody means: an until whose sides exclude each other.

`phi1 U_[a:b] phi2` asks for phi1 at the step where phi2 holds too (paper Sec. 3). Where the two
exclude each other, as in `(!A) U_[0:30] A`, it can hold on a boundary only. The strict until, phi1
up to the step before, is

    phi1 U_[a-1:b-1] F_[1:1] phi2                  if a > 0,
    phi2 | phi1 U_[0:b-1] F_[1:1] phi2             if a = 0, b > 0.
"""

from collections.abc import Iterator
from functools import lru_cache
from itertools import product

import numpy as np

from core.quoting import LONGEST_FORMULA, shown
from core.stl import (
    Always,
    And,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Until,
    atom_names,
    children,
    conjunction,
    fold_constants,
    is_state_formula,
    negation_normal_form,
    robustness,
    to_text,
)

MOST_ATOMS = 10
"""Names in both sides of an until up to which exclusion is decided."""


@lru_cache(maxsize=64)
def advice(formula: Formula) -> tuple[str, ...]:
    """A sentence for each until whose sides exclude each other, with what to write instead."""
    found = dict.fromkeys(until for until in _wanted(formula, True) if _exclusive(until))
    return tuple(_sentence(until) for until in found)


def strict_until(until: Until) -> Formula:
    """Left up to the step before right holds: an until without the end that both share."""
    (a, b), left, right = until.interval, until.left, until.right
    if b == 0:
        return right
    if a == 0 and negation_normal_form(Not(right)) == negation_normal_form(left):
        return Eventually(until.interval, right)
    following = Eventually(Interval(1, 1), right)
    earlier = Until(Interval(max(a - 1, 0), b - 1), left, following)
    return earlier if a else Or((right, earlier))


def _sentence(until: Until) -> str:
    text, better = (shown(to_text(f), LONGEST_FORMULA) for f in (until, strict_until(until)))
    return (
        f"`{text}` can hold on a boundary only: U asks for its left side at the step where its "
        f"right side holds too, and the two exclude each other. Up to the step before is `{better}`"
    )


def _wanted(formula: Formula, positive: bool) -> Iterator[Until]:
    """Untils under an even number of negations: those that must hold."""
    match formula:
        case Not(operand=operand):
            yield from _wanted(operand, not positive)
        case Implies(left=left, right=right):
            yield from _wanted(left, not positive)
            yield from _wanted(right, positive)
        case _:
            if isinstance(formula, Until) and positive:
                yield formula
            for child in children(formula):
                yield from _wanted(child, positive)


def _exclusive(until: Until) -> bool:
    """Whether no position satisfies what both sides ask for at once; False if undecided."""
    left, right = (negation_normal_form(fold_constants(f)) for f in (until.left, until.right))
    both = conjunction((*_now(left), *_now(right)))
    names = atom_names(both)
    if not 0 < len(names) <= MOST_ATOMS:
        return False
    signs = np.array(list(product([-1.0, 1.0], repeat=len(names))))
    return bool((robustness(both, signs[:, None, :], names) < 0).all())


def _now(formula: Formula) -> Iterator[Formula]:
    """State formulas that must hold at the step at which the formula does."""
    match formula:
        case _ if is_state_formula(formula):
            yield formula
        case And(operands=operands):
            for operand in operands:
                yield from _now(operand)
        case Until(left=held):
            yield from _now(held)
        case Always(interval=interval, operand=operand) if interval.start == 0:
            yield from _now(operand)
