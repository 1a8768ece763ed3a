"""Windows of one step and windows in each other, written with fewer operators.

    F_[c:c] f = G_[c:c] f                  G_[0:0] f = f, f temporal
    F_[a:b] F_[c:d] f = F_[a+c:b+d] f      G_[a:b] G_[c:d] f = G_[a+c:b+d] f
    G_[c:c] F_[a:b] f = F_[a:b] G_[c:c] f = F_[a+c:b+c] f
    f U_[c:c] g = G_[0:c] f & G_[c:c] g    !(f U_[c:c] g) = F_[0:c] !f | G_[c:c] !g

All keep the robustness of every trace.
"""

from dataclasses import replace

from core.stl.normal_form import negation_normal_form
from core.stl.syntax import (
    Always,
    And,
    Eventually,
    Formula,
    Interval,
    Not,
    Or,
    Span,
    Until,
    is_state_formula,
)


def simplify(formula: Formula) -> Formula:
    """Simplify a formula in negation normal form; the result is in that form too."""
    match formula:
        case And(operands=operands) | Or(operands=operands):
            return replace(formula, operands=tuple(map(simplify, operands)))
        case Eventually(interval=interval, operand=operand):
            return _eventually(interval, simplify(operand), formula.span)
        case Always(interval=interval, operand=operand):
            return _always(interval, simplify(operand), formula.span)
        case Until():
            return _until(formula)
        case Not(operand=Until() as until):
            return _negated_until(formula, until)
    return formula


def _eventually(interval: Interval, operand: Formula, span: Span | None) -> Formula:
    if interval.start == interval.stop:
        return _always(interval, operand, span)
    match operand:
        case Eventually(interval=inner) | Always(interval=inner) if (
            isinstance(operand, Eventually) or inner.start == inner.stop
        ):
            return Eventually(_sum(interval, inner), operand.operand, span=span)
    return Eventually(interval, operand, span=span)


def _always(interval: Interval, operand: Formula, span: Span | None) -> Formula:
    if interval == (0, 0) and not is_state_formula(operand):
        return operand
    match operand:
        case Always(interval=inner, operand=goal):
            return Always(_sum(interval, inner), goal, span=span)
        case Eventually(interval=inner, operand=goal) if interval.start == interval.stop:
            return Eventually(_sum(interval, inner), goal, span=span)
    return Always(interval, operand, span=span)


def _until(formula: Until) -> Formula:
    left, right = simplify(formula.left), simplify(formula.right)
    (first, last), span = formula.interval, formula.span
    if first < last:
        return replace(formula, left=left, right=right)
    held = _always(Interval(0, last), left, span)
    return And((held, _always(Interval(last, last), right, span)), span=span)


def _negated_until(formula: Not, until: Until) -> Formula:
    (first, last), span = until.interval, formula.span
    if first < last:
        left, right = simplify(until.left), simplify(until.right)
        return replace(formula, operand=replace(until, left=left, right=right))
    fails = simplify(negation_normal_form(Not(until.left)))
    never = simplify(negation_normal_form(Not(until.right)))
    failed = _eventually(Interval(0, last), fails, span)
    return Or((failed, _always(Interval(last, last), never, span)), span=span)


def _sum(outer: Interval, inner: Interval) -> Interval:
    return Interval(outer.start + inner.start, outer.stop + inner.stop)
