"""A stronger formula that decomposes, to offer where the one that was written does not.

Each rewriting replaces a subformula by one that implies it, at a place where that makes the whole
formula stronger (in negation normal form, anywhere but below a negated until):

    G_[a:b](phi1 & phi2)   G_[a:b](phi1) & G_[a:b](phi2)
    phi1 U_[a:b] phi2      G_[0:b](phi1) & F_[a:b](phi2)
    !(phi1 U_[a:b] phi2)   G_[a:b](!phi2)
    G_[a:b](phi1 | phi2)   G_[a:b](phi1) | G_[a:b](phi2)
    phi1 | phi2            phi1, or phi2
    F_[a:b](phi)           G_[a:a](phi)

The upper lines are tried first, and outer subformulas before inner ones, until `decompose` takes a
formula that does not ask for a name and its negation at the same step.
"""

import random
from collections.abc import Callable, Iterator

from core.decompose.grouping import flat
from core.decompose.model import Decomposition, DecompositionError
from core.decompose.rules import decompose
from core.errors import UserError
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
    children,
    fold_constants,
    is_state_formula,
    negation_normal_form,
    walk,
    with_children,
)

Rule = Callable[[Formula], Iterator[Formula]]

MOST_TRIED = 16
"""Formulas that are decomposed in search of one."""

MOST_SCHEDULES = 200
"""Schedules that are drawn in search of one without a contradiction."""

LARGEST = 400
"""Names and operators of a formula for which one is searched."""


def stronger(formula: Formula) -> Formula | None:
    """A formula that decomposes and implies the given one, which does not; None if none is found.

    Args:
        formula: what `decompose` refused.
    """
    normal = negation_normal_form(fold_constants(formula))
    if isinstance(normal, Constant) or _size(normal) > LARGEST:
        return None
    waiting, seen = [normal], {normal}
    for _ in range(MOST_TRIED):
        if not waiting:
            return None
        candidate = waiting.pop()
        refused = _refused(candidate)
        if refused is None:
            if _consistent(decompose(candidate)):
                return candidate
            continue
        for rule in reversed(_RULES):
            others = [new for new in _rewritings(candidate, refused, rule) if new not in seen]
            seen.update(others)
            waiting += [other for other in reversed(others) if _size(other) <= 2 * LARGEST]
    return None


def _refused(formula: Formula) -> Formula | None:
    """What `decompose` refuses in a formula; None if it takes it."""
    try:
        decompose(formula)
    except DecompositionError as error:
        return error.formula
    except UserError:
        return formula
    return None


def _rewritings(formula: Formula, refused: Formula, rule: Rule) -> Iterator[Formula]:
    """The formula with one subformula replaced, of those that contain what is refused."""
    if _touches(formula, refused) and not is_state_formula(formula):
        yield from rule(formula)
    if isinstance(formula, Not):
        return
    parts = children(formula)
    for index, part in enumerate(parts):
        for other in _rewritings(part, refused, rule):
            yield with_children(formula, (*parts[:index], other, *parts[index + 1 :]))


def _touches(formula: Formula, refused: Formula) -> bool:
    """Whether one of two formulas lies in the other; by places in the text if both have one."""
    ours, theirs = formula.span, refused.span
    if ours is None or theirs is None:
        return any(node == refused for node in walk(formula)) or isinstance(formula, Not)
    within = ours.start <= theirs.start and theirs.stop <= ours.stop
    return within or (theirs.start <= ours.start and ours.stop <= theirs.stop)


def _distributed(formula: Formula) -> Iterator[Formula]:
    match formula:
        case Always(interval=interval, operand=(And() | Or()) as joined):
            members = (Always(interval, each, span=formula.span) for each in flat(joined))
            yield type(joined)(tuple(members), span=formula.span)


def _without_until(formula: Formula) -> Iterator[Formula]:
    span = formula.span
    match formula:
        case Until(interval=interval, left=left, right=right):
            kept = Always(Interval(0, interval.stop), left, span=span)
            yield And((kept, Eventually(interval, right, span=span)), span=span)
        case Not(operand=Until(interval=interval, right=right)):
            yield Always(interval, negation_normal_form(Not(right)), span=span)


def _chosen(formula: Formula) -> Iterator[Formula]:
    if isinstance(formula, Or):
        yield from sorted(flat(formula), key=is_state_formula)


def _at_once(formula: Formula) -> Iterator[Formula]:
    match formula:
        case Eventually(interval=(a, _), operand=operand):
            yield Always(Interval(a, a), operand, span=formula.span) if a else operand


_RULES = (_distributed, _without_until, _chosen, _at_once)
"""From a formula to formulas that imply it, none if the rule is for another operator."""


def _consistent(decomposition: Decomposition) -> bool:
    """Whether under some schedule, of many drawn, no name is asked for and forbidden at a step."""
    variables = decomposition.variables
    draw = random.Random(0)
    drawn = ([draw.randint(v.low, v.high) for v in variables] for _ in range(MOST_SCHEDULES))
    highest = [v.high for v in variables]
    return any(
        decomposition.admissible(schedule) and not _clash(decomposition, schedule)
        for schedule in (highest, *drawn)
    )


def _clash(decomposition: Decomposition, schedule: list[int]) -> bool:
    wanted, forbidden = [], []
    for task, start, end in decomposition.active_tasks(schedule):
        if start <= end:
            for part in (
                flat(task.predicate) if isinstance(task.predicate, And) else [task.predicate]
            ):
                match part:
                    case Atom(name=name):
                        wanted.append((name, start, end))
                    case Not(operand=Atom(name=name)):
                        forbidden.append((name, start, end))
    return any(
        name == other and max(start, first) <= min(end, last)
        for name, start, end in wanted
        for other, first, last in forbidden
    )


def _size(formula: Formula) -> int:
    return sum(1 for _ in walk(formula))
