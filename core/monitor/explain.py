"""One sentence on a verdict: what failed first and when, or what was closest to failing."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np

from core.monitor import wording
from core.monitor.misses import Misses
from core.monitor.search import Event, Search, only_atom
from core.monitor.signals import FailureSignals, Signals
from core.monitor.witness import decisive
from core.stl import (
    And,
    Constant,
    Formula,
    check_trace,
    fold_constants,
    negation_normal_form,
    samples_read,
)


@dataclass(frozen=True)
class Diagnosis:
    """Why a trace satisfies a formula or not.

    Attributes:
        satisfied: the verdict, robustness >= 0.
        robustness: of the formula at step 0 [m]; -inf if a number that the formula reads is not
            finite.
        sentence: for a person.
        step: where to look; None if no step is special.
        atom: name of the region to look at; None if no single one decides.
    """

    satisfied: bool
    robustness: float
    sentence: str
    step: int | None = None
    atom: str | None = None


def diagnose(formula: Formula, margins: np.ndarray, names: Sequence[str], dt: float) -> Diagnosis:
    """Find what decided the verdict.

    Args:
        formula: its atoms are among the names.
        margins: [T, A] of one trace [m], T > horizon(formula).
        names: of the columns.
        dt: duration of a step [s].

    Raises:
        TraceError: margins of a wrong shape, too few steps, or an atom without margins.
    """
    check_trace(formula, margins, names)
    signals, clock = Signals(margins, names), wording.Clock(dt)
    margins = signals.margins[:, : len(names)]
    broken = ~np.isfinite(margins) & samples_read(formula, len(margins), names)
    if broken.any():
        step = int(broken.any(axis=1).argmax())
        why = f"the simulation broke down at {clock.step(step)}: its numbers are no longer finite"
        return Diagnosis(False, -np.inf, f"Violated: {why}.", step)
    formula = fold_constants(formula)
    robustness = float(signals[formula][0])
    if isinstance(formula, Constant):
        holds = "holds" if formula.value else "fails"
        verdict = "Satisfied" if formula.value else "Violated"
        sentence = f"{verdict}: the formula {holds} whatever the robot does."
        return Diagnosis(formula.value, robustness, sentence)
    normal = negation_normal_form(formula)
    if robustness >= 0:
        return _satisfied(formula, normal, robustness, signals, clock)
    search = Search(signals, FailureSignals(margins, names), Misses(signals), clock)
    event = search.event(normal, 0)
    return Diagnosis(
        False, robustness, _violated(event, _originals(formula)), event.step, event.atom
    )


def _satisfied(
    formula: Formula, normal: Formula, robustness: float, signals: Signals, clock: wording.Clock
) -> Diagnosis:
    witness = decisive(normal, 0, signals)
    where = wording.margin_at(witness.literal, robustness, clock.step(witness.step))
    required = _originals(formula).get(witness.requirement, witness.requirement)
    sentence = f"Satisfied; the tightest margin is {where}"
    if required != formula:
        sentence += f", for {wording.quoted(required)}"
    return Diagnosis(True, robustness, f"{sentence}.", witness.step, only_atom(witness.literal))


def _originals(formula: Formula) -> dict[Formula, Formula]:
    """The conjuncts as they were written, by their normal form."""
    found = {negation_normal_form(formula): formula}
    if isinstance(formula, And):
        for operand in formula.operands:
            found |= _originals(operand)
    return found


def _violated(event: Event, originals: dict[Formula, Formula]) -> str:
    sentence = f"Violated: {_circumstances(event)}{event.text}"
    if event.requirement is not None:
        required = originals.get(event.requirement, event.requirement)
        sentence += f", but {wording.quoted(required)} {event.demand}"
    return sentence + "."


def _circumstances(event: Event) -> str:
    """The clauses as they are; attempts within attempts together."""
    text = ""
    for is_step, group in groupby(event.circumstances, lambda each: isinstance(each, int)):
        if is_step:
            text += f"in the closest attempt (step {', then '.join(map(str, group))}), "
        else:
            text += "".join(map(str, group))
    return text
