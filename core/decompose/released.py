"""A negated until as a disjunction, for the rules that hold throughout a window."""

from core.stl import (
    Always,
    Eventually,
    Formula,
    Interval,
    Not,
    Span,
    Until,
    disjunction,
    negation_normal_form,
    simplify,
)


def released(until: Until, span: Span | None) -> Formula:
    """`!(phi1 U_[a:b] phi2)` in normal form, a < b: phi2 never holds, or phi1 fails before.

    G_[a:b] !phi2 | F_[0:a] !phi1 | G_[a:a](!phi2 U_[0:b-a-1] G_[1:1] !phi1): phi1 fails by step a,
    or the step before the failure is reached without phi2.
    """
    (a, b), fails, never = (
        until.interval,
        negation_normal_form(Not(until.left)),
        negation_normal_form(Not(until.right)),
    )
    before = Until(Interval(0, b - a - 1), never, Always(Interval(1, 1), fails))
    parts = (
        Always(Interval(a, b), never, span=span),
        Eventually(Interval(0, a), fails, span=span),
        Always(Interval(a, a), before, span=span),
    )
    return simplify(disjunction(parts, span=span))
