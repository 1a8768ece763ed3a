"""A formula read back in English, one sentence for each conjunct.

    F_[40:80](A2 & F_[10:20](G_[0:10](A3)))    steps of 0.2 s
    Between 8 s and 16 s be in A2, and 2 to 4 s later stay 2 s in A3.

The sentences are made from the syntax tree and say the same, neither more nor less. Times of a
sentence count from the start of the episode; times that are `later` count from the moment that
stands before them; those in parentheses and behind a colon from the moment before these.
"""

from collections.abc import Sequence
from fractions import Fraction

from core.stl.places import place
from core.stl.printer import to_text
from core.stl.syntax import (
    Always,
    And,
    Eventually,
    Formula,
    Implies,
    Interval,
    Not,
    Or,
    Until,
    is_state_formula,
)

_MOST_DECIMALS = 4
"""Of a time step that is told in seconds."""


def sentences(formula: Formula, dt: float | None = None) -> tuple[str, ...]:
    """Read a formula back.

    Args:
        formula: any formula.
        dt: duration of a step [s]; times are told in steps if None, or if seconds would be long
            numbers.
    """
    clock = _Clock(dt)
    return tuple(_sentence(_clause(part, clock, True)) for part in conjuncts(formula))


def conjuncts(formula: Formula) -> Sequence[Formula]:
    """The members of a conjunction, those of conjunctions within it included."""
    if not isinstance(formula, And) or equivalent(formula):
        return (formula,)
    return [part for operand in formula.operands for part in conjuncts(operand)]


def equivalent(formula: Formula) -> tuple[Formula, Formula] | None:
    """The two sides of `<->`, whose conjunction has become one of two implications."""
    match formula:
        case And(operands=(Implies(left=a, right=b), Implies(left=c, right=d))) if (a, b) == (d, c):
            return a, b
    return None


class _Clock:
    """Says times in seconds or in steps."""

    def __init__(self, dt: float | None):
        step = None if dt is None else Fraction(str(dt))
        exact = step is not None and (step * 10**_MOST_DECIMALS).denominator == 1
        self._step = step if exact else None

    def span(self, interval: Interval) -> str:
        """`2 to 4 s`, `2 s`, `10 to 20 steps`."""
        start, stop = interval
        if start == stop:
            return self.time(start)
        return f"{self._number(start)} to {self.time(stop)}"

    def time(self, steps: int) -> str:
        """`2 s`, `10 steps`."""
        if self._step is None:
            return f"{steps} step{'' if steps == 1 else 's'}"
        return f"{self._number(steps)} s"

    def moment(self, steps: int) -> str:
        """`2 s`, `step 10`."""
        return f"step {steps}" if self._step is None else self.time(steps)

    def _number(self, steps: int) -> str:
        if self._step is None:
            return str(steps)
        whole = f"{float(steps * self._step):.{_MOST_DECIMALS}f}"
        return whole.rstrip("0").rstrip(".")


def _clause(formula: Formula, clock: _Clock, absolute: bool) -> str:
    """What to do, from the start of the episode if `absolute`, else from a moment before it."""
    if is_state_formula(formula):
        return f"{'at ' + clock.moment(0) + ' ' if absolute else ''}be {place(formula)}"
    match formula:
        case Not(operand=operand):
            return _negation(operand, clock, absolute)
        case And() if sides := equivalent(formula):
            left, right = (_clause(side, clock, absolute) for side in sides)
            return f"do both or neither of ({left}; {right})"
        case And():
            return _all_of(formula, clock, absolute)
        case Or(operands=operands):
            choices = "; ".join(_clause(each, clock, absolute) for each in operands)
            return f"do at least one of ({choices})"
        case Implies(left=left, right=right):
            return f"if {_condition(left, clock, absolute)} then {_clause(right, clock, absolute)}"
        case Eventually(interval=interval, operand=operand):
            return f"{_at(interval, clock, absolute)} {_clause(operand, clock, False)}"
        case Always(interval=interval, operand=operand):
            return _throughout(interval, operand, clock, absolute)
        case Until():
            return _until(formula, clock, absolute)
    raise TypeError(f"not a formula: {to_text(formula)}")


def _all_of(formula: And, clock: _Clock, absolute: bool) -> str:
    """`be in A, and ...`; more than one temporal part stands in parentheses."""
    parts = conjuncts(formula)
    temporal = [part for part in parts if not is_state_formula(part)]
    states = [part for part in parts if is_state_formula(part)]
    clauses = []
    if states:
        joined = states[0] if len(states) == 1 else And(tuple(states))
        clauses.append(_clause(joined, clock, absolute))
    clauses += [_clause(part, clock, absolute) for part in temporal]
    if len(temporal) == 1:
        return ", and ".join(clauses)
    return f"do all of ({'; '.join(clauses)})"


def _at(interval: Interval, clock: _Clock, absolute: bool) -> str:
    """When something happens once."""
    start, stop = interval
    if not absolute:
        return "at that moment" if stop == 0 else f"{clock.span(interval)} later"
    if start == stop:
        return f"at {clock.moment(start)}"
    return f"between {clock.moment(start)} and {clock.moment(stop)}"


def _throughout(interval: Interval, operand: Formula, clock: _Clock, absolute: bool) -> str:
    """What holds at every step of an interval."""
    start, stop = interval
    if start == stop:
        return f"{_at(interval, clock, absolute)} {_clause(operand, clock, False)}"
    if absolute:
        window = f"from {clock.moment(start)} to {clock.moment(stop)}"
    else:
        window = f"from {clock.span(interval)} later"
    if not is_state_formula(operand):
        return f"at every moment {window}: {_clause(operand, clock, False)}"
    if start == 0 and not absolute:
        return f"stay {clock.time(stop)} {place(operand)}"
    return f"{window} stay {place(operand)}"


def _until(formula: Until, clock: _Clock, absolute: bool) -> str:
    """The left side up to and including the moment of the right side."""
    interval, left = formula.interval, formula.left
    if absolute and interval.start != interval.stop:
        moment = f"a moment {_at(interval, clock, True)}"
    elif absolute:
        moment = clock.moment(interval.start)
    elif interval.stop == 0:
        moment = "that moment"
    else:
        moment = f"the moment {_at(interval, clock, False)}"
    goal = f"and then, at that moment, {_clause(formula.right, clock, False)}"
    if is_state_formula(left):
        return f"stay {place(left)} up to and including {moment}, {goal}"
    every = f"at every moment up to and including {moment} do ({_clause(left, clock, False)})"
    return f"{every}, {goal}"


def _negation(formula: Formula, clock: _Clock, absolute: bool) -> str:
    """What must not happen: turned into what must, where that is a state."""
    match formula:
        case Eventually(interval=interval, operand=operand) if is_state_formula(operand):
            return _clause(Always(interval, Not(operand)), clock, absolute)
        case Always(interval=interval, operand=operand) if is_state_formula(operand):
            return _clause(Eventually(interval, Not(operand)), clock, absolute)
        case Not(operand=operand):
            return _clause(operand, clock, absolute)
    return f"never do ({_clause(formula, clock, absolute)})"


def _condition(formula: Formula, clock: _Clock, absolute: bool) -> str:
    if not is_state_formula(formula):
        return f"this is done ({_clause(formula, clock, absolute)})"
    now = f" at {clock.moment(0)}" if absolute else ""
    return f"{place(formula)}{now}"


def _sentence(clause: str) -> str:
    return f"{clause[0].upper()}{clause[1:]}."
