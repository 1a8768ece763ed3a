"""Which atom, at which step, decides the robustness of a formula that holds.

Follow the operand of each minimum that attains it and of each maximum that attains it first. All
formulas here are in negation normal form and without constants.
"""

from typing import NamedTuple

import numpy as np

from core.monitor.signals import Signals
from core.stl import (
    Always,
    And,
    Eventually,
    Formula,
    Not,
    Or,
    Until,
    is_state_formula,
    negation_normal_form,
)


class Witness(NamedTuple):
    """The literal that decides, its step, and the innermost requirement that it belongs to."""

    literal: Formula
    step: int
    requirement: Formula


def decisive(formula: Formula, step: int, signals: Signals) -> Witness:
    """Find the literal whose margin equals the robustness at a step, up to its sign."""
    return _decisive(formula, step, signals, formula)


def _decisive(formula: Formula, step: int, signals: Signals, within: Formula) -> Witness:
    match formula:
        case And(operands=operands):
            worst = min(operands, key=lambda each: signals[each][step])
            return _decisive(worst, step, signals, _requirement(worst, within, formula))
        case Or(operands=operands):
            best = max(operands, key=lambda each: signals[each][step])
            return _decisive(best, step, signals, _requirement(best, within, formula))
        case Always(interval=(a, b), operand=operand):
            later = step + a + int(np.argmin(signals[operand][step + a : step + b + 1]))
            return _decisive(operand, later, signals, formula)
        case Eventually(interval=(a, b), operand=operand):
            later = step + a + int(np.argmax(signals[operand][step + a : step + b + 1]))
            return _decisive(operand, later, signals, formula)
        case Until():
            return _of_until(formula, step, signals, formula)
        case Not(operand=Until() as until):
            return _of_until(until, step, signals, formula)
    return Witness(formula, step, within)


def _requirement(operand: Formula, within: Formula, parent: Formula) -> Formula:
    """A conjunct of the formula itself is a requirement of its own."""
    return operand if within is parent and not is_state_formula(parent) else within


def _of_until(until: Until, step: int, signals: Signals, within: Formula) -> Witness:
    """Of an until, or of its negation (then `within` is not the until)."""
    goal_step, held_step, goal_decides = _best_meeting(until, step, signals)
    operand, at = (until.right, goal_step) if goal_decides else (until.left, held_step)
    if within is not until:
        operand = negation_normal_form(Not(operand))
    return _decisive(operand, at, signals, within)


def _best_meeting(until: Until, step: int, signals: Signals) -> tuple[int, int, bool]:
    """Where an until is met best.

    Returns:
        The step of its right side, the step at which its left side was worst until then, and
        whether the right side decides.
    """
    a, b = until.interval
    left = signals[until.left][step : step + b + 1]
    right = signals[until.right][step + a : step + b + 1]
    held = np.minimum.accumulate(left)[a:]
    best = int(np.argmax(np.minimum(right, held)))
    worst = int(np.argmin(left[: a + best + 1]))
    return step + a + best, step + worst, bool(right[best] <= held[best])
