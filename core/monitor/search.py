"""What made a formula fail: an event on the trace, and the requirement that it breaks.

A violated formula in negation normal form is followed down to a state formula: at a conjunction
and a G the part that fails first (`FailureSignals`), at a disjunction and an F the alternative
that came closest.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from core.monitor import wording
from core.monitor.signals import FailureSignals, Signals
from core.monitor.witness import best_meeting
from core.stl import (
    Always,
    And,
    Constant,
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
        tries: steps of the closest attempts at F operators, outermost first.
        preface: the circumstances, as the beginning of a sentence.
    """

    text: str
    step: int
    atom: str | None
    requirement: Formula | None = None
    demand: str = ""
    tries: tuple[int, ...] = ()
    preface: str = ""


@dataclass(frozen=True)
class Search:
    """Follows a violated formula down to an event."""

    signals: Signals
    failures: FailureSignals
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
        def order(operand: Formula) -> tuple[float, float]:
            return float(self.failures[operand][step]), float(self.signals[operand][step])

        return min((each for each in operands if self.signals[each][step] < 0), key=order)

    def _breach(self, formula: Formula, step: int, last: int, required: Formula) -> Event:
        """A state formula that fails at a step, perhaps also at steps after it up to `last`."""
        if isinstance(formula, And):
            worst = self._first_to_fail(formula.operands, step)
            return self._breach(worst, step, last, required)
        if isinstance(formula, Constant):
            return Event("false can never hold", step, None)
        holds = self.signals[formula][step : last + 1] >= 0
        length = int(holds.argmax()) if holds.any() else len(holds)
        short = float(-self.signals[formula][step : step + length].min())
        when = self.clock.steps(step, step + length - 1)
        text = wording.breach(formula, when, short, length > 1)
        return Event(text, step, only_atom(formula), required, wording.demand(formula))

    def _never(self, formula: Eventually, step: int) -> Event:
        """No step of the window of an F will do."""
        simpler = self._simpler(formula, step)
        if simpler is not None:
            return self._never(simpler, step)
        operand, first = formula.operand, step + formula.interval.start
        last = step + formula.interval.stop
        if isinstance(operand, Constant) or (first == last and is_state_formula(operand)):
            return self._breach(operand, first, first, formula)
        if first == last:
            return self.event(operand, first)
        nearest = self._nearest(operand, first, last)
        if not is_state_formula(operand):
            event = self.event(operand, nearest)
            return replace(event, tries=(nearest, *event.tries))
        short = float(-self.signals[operand][nearest])
        between, at = self.clock.between(first, last), self.clock.step(nearest)
        text = wording.miss(operand, between, short, at)
        return Event(text, nearest, only_atom(operand))

    def _simpler(self, formula: Eventually, step: int) -> Eventually | None:
        """An F that the given one needs and that failed too, with a simpler operand."""
        a, b = formula.interval
        match formula.operand:
            case And(operands=operands):
                hopeless = [each for each in operands if self._fails(each, step + a, step + b)]
                if hopeless:
                    return Eventually(formula.interval, self._first_to_fail(hopeless, step + a))
            case Eventually(interval=(c, d), operand=inner):
                return Eventually(Interval(a + c, b + d), inner)
            case Always(interval=(c, d), operand=inner):
                if self._fails(inner, step + a + c, step + b + d):
                    return Eventually(Interval(a + c, b + d), inner)
        return None

    def _fails(self, formula: Formula, first: int, last: int) -> bool:
        return bool((self.signals[formula][first : last + 1] < 0).all())

    def _nearest(self, formula: Formula, first: int, last: int) -> int:
        """The step of [first, last] from which the formula came closest.

        That is where it failed after the longest time; of several, where it missed by the least.
        """
        lasted = self.failures[formula][first : last + 1] - np.arange(first, last + 1)
        order = np.lexsort((-self.signals[formula][first : last + 1], -lasted))
        return first + int(order[0])

    def _no_alternative(self, formula: Or, step: int) -> Event:
        """All alternatives fail; where a condition made the only temporal one due, say so."""
        temporal = [each for each in formula.operands if not is_state_formula(each)]
        conditions = [each for each in formula.operands if is_state_formula(each)]
        closest = max(temporal, key=lambda each: float(self.signals[each][step]))
        event = self.event(closest, step)
        if conditions and len(temporal) == 1:
            due = negation_normal_form(Not(disjunction(conditions)))
            preface = f"when {wording.holding(due)} at {self.clock.step(step)}, "
        else:
            alternatives = wording.quoted(formula)
            preface = f"no alternative of {alternatives} held; the closest failed because "
        return replace(event, preface=preface + event.preface)

    def _until(self, formula: Until, step: int) -> Event:
        """The left side failed too early, or else the right side was never there."""
        last = step + formula.interval.stop
        left, goal = formula.left, wording.arrival(formula.right)
        failed = np.flatnonzero(self.signals[left][step : last + 1] < 0)
        if not failed.size:
            return self._never(Eventually(formula.interval, formula.right), step)
        first = step + int(failed[0])
        if is_state_formula(left):
            event = self._breach(left, first, last, formula)
            return replace(event, text=f"{event.text}, before {goal}")
        event = self.event(left, first)
        preface = f"{wording.quoted(left)} failed before {goal}: "
        return replace(event, preface=preface + event.preface)

    def _until_held(self, formula: Not, until: Until, step: int) -> Event:
        met, _, _ = best_meeting(until, step, self.signals)
        held = f"{wording.quoted(until.left)} held until {wording.quoted(until.right)} did"
        text = f"{held} at {self.clock.step(met)}"
        return Event(text, met, only_atom(until.right), formula, "forbids it")


def only_atom(formula: Formula) -> str | None:
    """Name of the only atom of a formula; None if it has several."""
    names = atom_names(formula)
    return names[0] if len(names) == 1 else None
