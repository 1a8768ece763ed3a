"""One sentence on a verdict: what failed first and when, or what was closest to failing."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.monitor import wording
from core.monitor.search import Event, Search, only_atom
from core.monitor.signals import FailureSignals, Signals, check_names
from core.monitor.witness import decisive
from core.stl import And, Formula, TraceError, horizon, negation_normal_form


@dataclass(frozen=True)
class Diagnosis:
    """Why a trace satisfies a formula or not.

    Attributes:
        satisfied: the verdict, robustness >= 0.
        robustness: of the formula at step 0 [m]; -inf where the trace has a number that is not
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


def explain(formula: Formula, margins: np.ndarray, names: Sequence[str], dt: float) -> str:
    """Say in one sentence why a trace satisfies a formula or not; see `diagnose`."""
    return diagnose(formula, margins, names, dt).sentence


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
    check_names(formula, names)
    signals, clock = Signals(margins, names), wording.Clock(dt)
    if len(signals.margins) <= horizon(formula):
        raise TraceError(
            f"the trace has {len(signals.margins)} steps; the formula needs at least "
            f"{horizon(formula) + 1}"
        )
    broken = np.flatnonzero(~np.isfinite(signals.margins[:, : len(names)]).all(axis=1))
    if broken.size:
        step = int(broken[0])
        why = "the simulation broke down: its numbers are no longer finite"
        return Diagnosis(False, -np.inf, f"Violated: {why} from {clock.step(step)} on.", step)
    normal = negation_normal_form(formula)
    robustness = float(signals[formula][0])
    if robustness >= 0:
        return _satisfied(formula, normal, robustness, signals, clock)
    failures = FailureSignals(margins, names)
    event = Search(signals, failures, clock).event(normal, 0)
    return Diagnosis(
        False, robustness, _violated(event, _originals(formula)), event.step, event.atom
    )


def _satisfied(
    formula: Formula, normal: Formula, robustness: float, signals: Signals, clock: wording.Clock
) -> Diagnosis:
    witness = decisive(normal, 0, signals)
    if witness is None:
        return Diagnosis(True, robustness, "Satisfied: it holds whatever the robot does.")
    where = wording.margin_at(witness.literal, robustness, clock.step(witness.step))
    required = _originals(formula).get(witness.requirement, witness.requirement)
    sentence = f"Satisfied; tightest {where}"
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
    tries = ""
    if event.tries:
        steps = ", then ".join(map(str, event.tries))
        tries = f"in the closest attempt (step {steps}), "
    sentence = f"Violated: {event.preface}{tries}{event.text}"
    if event.requirement is not None:
        required = originals.get(event.requirement, event.requirement)
        sentence += f", but {wording.quoted(required)} {event.demand}"
    return sentence + "."
