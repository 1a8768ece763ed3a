"""What made a formula fail: an event on the trace, and the requirement that it breaks.

A violated formula in negation normal form is followed down to a state formula: at a conjunction
and a G the part that fails for good first (`FailureSignals`), at an F the attempt that misses
least (`Misses`), at a disjunction the alternative of the greatest robustness.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from core.monitor import wording
from core.monitor.misses import Misses
from core.monitor.signals import FailureSignals, Signals
from core.stl import (
    Always,
    And,
    Eventually,
    Formula,
    Interval,
    Not,
    Or,
    Until,
    atom_names,
    disjunction,
    is_state_formula,
    negation_normal_form,
    to_text,
)


@dataclass(frozen=True)
class Event:
    """What went wrong.

    Attributes:
        text: the event, as a clause.
        step: when it happened, or came closest to happening.
        atom: the region concerned, if it is a single one.
        requirement: innermost requirement that the event breaks; None if the text says it.
        demand: what the requirement does: `forbids it`.
        circumstances: outermost first, clauses and the steps of the closest attempts at F
            operators.
    """

    text: str
    step: int
    atom: str | None
    requirement: Formula | None = None
    demand: str = ""
    circumstances: tuple[str | int, ...] = ()

    def under(self, *circumstances: str | int) -> "Event":
        """Add circumstances around those that are known."""
        return replace(self, circumstances=(*circumstances, *self.circumstances))


@dataclass(frozen=True)
class Search:
    """Follows a violated formula down to an event."""

    signals: Signals
    failures: FailureSignals
    misses: Misses
    clock: wording.Clock

    def event(self, formula: Formula, step: int) -> Event:
        """Find why the formula fails at a step."""
        if is_state_formula(formula):
            return self._breach(formula, step, step, formula)
        match formula:
            case And(operands=operands):
                return self.event(self._first_to_fail(operands, step), step)
            case Or():
                return self._no_alternative(formula, step)
            case Always(interval=(a, b), operand=operand):
                failing = step + a + int(self.failures[operand][step + a : step + b + 1].argmin())
                if is_state_formula(operand):
                    return self._breach(operand, failing, step + b, formula)
                return self.event(operand, failing)
            case Eventually():
                return self._never(formula, step)
            case Until():
                return self._until(formula, step)
            case Not(operand=Until() as until):
                return self._until_held(formula, until, step)
        raise TypeError(f"not in negation normal form: {to_text(formula)}")

    def _first_to_fail(self, operands: Sequence[Formula], step: int) -> Formula:
        failed = (each for each in operands if self.signals[each][step] < 0)
        return min(failed, key=lambda each: self._order(each, step))

    def _order(self, formula: Formula, step: int) -> tuple[float, float]:
        """What fails for good first comes first; of several, what misses by most."""
        return float(self.failures[formula][step]), float(self.signals[formula][step])

    def _breach(self, formula: Formula, step: int, last: int, required: Formula) -> Event:
        """A state formula that fails at a step, perhaps also at steps after it up to `last`."""
        if isinstance(formula, And):
            worst = self._first_to_fail(formula.operands, step)
            return self._breach(worst, step, last, required)
        holds = self.signals[formula][step : last + 1] >= 0
        length = int(holds.argmax()) if holds.any() else len(holds)
        short = float(-self.signals[formula][step : step + length].min())
        when = self.clock.steps(step, step + length - 1)
        text = wording.breach(formula, when, short, length > 1)
        demand = None if required == formula and not wording.literal(formula) else required
        return Event(text, step, only_atom(formula), demand, wording.demand(formula))

    def _never(self, formula: Eventually, step: int) -> Event:
        """No step of the window of an F will do."""
        simpler = self._simpler(formula, step)
        if simpler is not None:
            return self._never(simpler, step)
        operand, first = formula.operand, step + formula.interval.start
        last = step + formula.interval.stop
        if first == last and is_state_formula(operand):
            return self._breach(operand, first, first, formula)
        if first == last:
            return self.event(operand, first)
        nearest = self._nearest(operand, first, last)
        if not is_state_formula(operand):
            return self.event(operand, nearest).under(nearest)
        short = float(-self.signals[operand][nearest])
        between, at = self.clock.between(first, last), self.clock.step(nearest)
        text = wording.miss(operand, between, short, at)
        return Event(text, nearest, only_atom(operand))

    def _simpler(self, formula: Eventually, step: int) -> Eventually | None:
        """An F that the given one needs and that failed too, with a simpler operand."""
        a, b = formula.interval
        match formula.operand:
            case And(operands=operands):
                hopeless = [Eventually(formula.interval, each) for each in operands]
                hopeless = [each for each in hopeless if self.signals[each][step] < 0]
                if hopeless:
                    return min(hopeless, key=lambda each: self._order(each, step))
            case Eventually(interval=(c, d), operand=inner):
                return Eventually(Interval(a + c, b + d), inner)
            case Always(interval=(c, d), operand=inner):
                never = Eventually(Interval(a + c, b + d), inner)
                if self.signals[never][step] < 0:
                    return never
        return None

    def _nearest(self, formula: Formula, first: int, last: int) -> int:
        """The step of [first, last] from which the formula misses least.

        Of several, the one that misses by the smallest distance, then that which fails last.
        """
        window = slice(first, last + 1)
        lasted = self.failures[formula][window] - np.arange(first, last + 1)
        order = np.lexsort((-lasted, -self.signals[formula][window], self.misses[formula][window]))
        return first + int(order[0])

    def _no_alternative(self, formula: Or, step: int) -> Event:
        """All alternatives fail; where a condition made the only temporal one due, say so."""
        temporal = [each for each in formula.operands if not is_state_formula(each)]
        conditions = [each for each in formula.operands if is_state_formula(each)]
        closest = max(temporal, key=lambda each: float(self.signals[each][step]))
        event = self.event(closest, step)
        if conditions and len(temporal) == 1:
            due = negation_normal_form(Not(disjunction(conditions)))
            return event.under(f"when {wording.holding(due)} at {self.clock.step(step)}, ")
        alternatives = wording.quoted(formula)
        return event.under(f"every alternative of {alternatives} failed; in the closest, ")

    def _until(self, formula: Until, step: int) -> Event:
        """The left side failed, or the right side never held; what was lost for good first."""
        (a, b), left, right = formula.interval, formula.left, formula.right
        reached = np.flatnonzero(self.signals[right][step + a : step + b + 1] >= 0)
        due = step + a + int(reached[0]) if reached.size else step + b
        lost = self.failures[left][step : due + 1]
        never = Eventually(formula.interval, right)
        if not reached.size and self.failures[never][step] < lost.min():
            return self._never(never, step)
        first = step + int(lost.argmin())
        before = self._before(formula, first)
        if is_state_formula(left):
            event = self._breach(left, first, due, formula)
            return replace(event, text=f"{event.text}, {before}") if before else event
        failed = f"{wording.quoted(left)} failed {before}".rstrip()
        return self.event(left, first).under(f"{failed}: ")

    def _before(self, until: Until, failed: int) -> str:
        """How a failure stands to the goal of its until; empty if the goal could come too early."""
        if until.interval.start > 0:
            return ""
        reached = self.signals[until.right][failed] >= 0
        return f"{'when' if reached else 'before'} {wording.arrival(until.right)}"

    def _until_held(self, formula: Not, until: Until, step: int) -> Event:
        """The until was met, for good first with the right side at the step found here."""
        (a, b), left, right = until.interval, until.left, until.right
        fails, never = negation_normal_form(Not(left)), negation_normal_form(Not(right))
        held = np.maximum.accumulate(self.failures[fails][step : step + b + 1])[a:]
        goal = self.failures[never][step + a : step + b + 1]
        met = step + a + int(np.maximum(held, goal).argmin())
        text = f"{wording.quoted(left)} held until {wording.quoted(right)} held"
        if is_state_formula(right):
            text = f"{text} at {self.clock.step(met)}"
            return Event(text, met, only_atom(right), formula, "forbids it")
        event = self.event(never, met).under(f"{text}: ")
        return replace(event, requirement=formula, demand="forbids it")


def only_atom(formula: Formula) -> str | None:
    """Name of the only atom of a formula; None if it has several."""
    names = atom_names(formula)
    return names[0] if len(names) == 1 else None
