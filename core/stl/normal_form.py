"""Negation normal form and removal of constants. Both keep the robustness of every trace."""

from dataclasses import replace

from core.stl.syntax import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Until,
    children,
    conjunction,
    disjunction,
)


def negation_normal_form(formula: Formula) -> Formula:
    """Remove implications and move negations inwards.

    In the result a negation stands only on an atom or on an until (the syntax has no release).
    """
    match formula:
        case Constant() | Atom():
            return formula
        case Not(operand=operand):
            return _negated(operand, formula)
        case Implies(left=left, right=right):
            return Or((_negated(left, left), negation_normal_form(right)), span=formula.span)
        case And(operands=operands) | Or(operands=operands):
            return replace(formula, operands=tuple(map(negation_normal_form, operands)))
        case Eventually(operand=operand) | Always(operand=operand):
            return replace(formula, operand=negation_normal_form(operand))
        case Until(left=left, right=right):
            return replace(
                formula, left=negation_normal_form(left), right=negation_normal_form(right)
            )
    raise TypeError(f"not a formula: {formula!r}")


def _negated(formula: Formula, source: Formula) -> Formula:
    """Normalise the negation of a formula; `source` is the node whose place it takes."""
    span = source.span
    match formula:
        case Constant(value=value):
            return Constant(not value, span=span)
        case Atom():
            return Not(formula, span=span)
        case Not(operand=operand):
            return negation_normal_form(operand)
        case And(operands=operands):
            return Or(tuple(_negated(each, each) for each in operands), span=span)
        case Or(operands=operands):
            return And(tuple(_negated(each, each) for each in operands), span=span)
        case Implies(left=left, right=right):
            return And((negation_normal_form(left), _negated(right, right)), span=span)
        case Eventually(interval=interval, operand=operand):
            return Always(interval, _negated(operand, operand), span=span)
        case Always(interval=interval, operand=operand):
            return Eventually(interval, _negated(operand, operand), span=span)
        case Until():
            return Not(negation_normal_form(formula), span=span)
    raise TypeError(f"not a formula: {formula!r}")


def fold_constants(formula: Formula) -> Formula:
    """Remove `true` and `false`: the result contains a constant only if it is one."""
    match formula:
        case Constant() | Atom():
            return formula
        case Not(operand=operand):
            folded = fold_constants(operand)
            if isinstance(folded, Constant):
                return Constant(not folded.value, span=formula.span)
            return replace(formula, operand=folded)
        case And(operands=operands):
            kept = _without_neutral(operands, True)
            return (
                Constant(False, span=formula.span)
                if kept is None
                else conjunction(kept, span=formula.span)
            )
        case Or(operands=operands):
            kept = _without_neutral(operands, False)
            return (
                Constant(True, span=formula.span)
                if kept is None
                else disjunction(kept, span=formula.span)
            )
        case Implies(left=left, right=right):
            return _fold_implication(formula, fold_constants(left), fold_constants(right))
        case Eventually(operand=operand) | Always(operand=operand):
            folded = fold_constants(operand)
            return folded if isinstance(folded, Constant) else replace(formula, operand=folded)
        case Until(left=left, right=right):
            return _fold_until(formula, fold_constants(left), fold_constants(right))
    raise TypeError(f"not a formula: {formula!r}")


def _without_neutral(operands: tuple[Formula, ...], neutral: bool) -> list[Formula] | None:
    """Folded operands but the neutral constants; None if one of them decides the result."""
    folded = [fold_constants(operand) for operand in operands]
    if Constant(not neutral) in folded:
        return None
    return [operand for operand in folded if operand != Constant(neutral)]


def _fold_implication(formula: Implies, left: Formula, right: Formula) -> Formula:
    match left, right:
        case (Constant(value=False), _) | (_, Constant(value=True)):
            return Constant(True, span=formula.span)
        case Constant(value=True), _:
            return right
        case _, Constant(value=False):
            return Not(left, span=formula.span)
    return replace(formula, left=left, right=right)


def _fold_until(formula: Until, left: Formula, right: Formula) -> Formula:
    """Fold: `true U phi` is `F phi`; `phi U_[a:b] true` is `G_[0:a] phi`."""
    match left, right:
        case (Constant(value=False), _) | (_, Constant(value=False)):
            return Constant(False, span=formula.span)
        case Constant(value=True), Constant(value=True):
            return Constant(True, span=formula.span)
        case Constant(value=True), _:
            return Eventually(formula.interval, right, span=formula.span)
        case _, Constant(value=True):
            return Always(Interval(0, formula.interval.start), left, span=formula.span)
    return replace(formula, left=left, right=right)


def literals(formula: Formula) -> list[tuple[str, bool]]:
    """Atoms of a formula in negation normal form, and whether they stand without a negation."""
    match formula:
        case Atom(name=name):
            return [(name, True)]
        case Not(operand=Atom(name=name)):
            return [(name, False)]
    return [literal for child in children(formula) for literal in literals(child)]
