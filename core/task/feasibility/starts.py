"""From which part of the initial set a mission breaks the formula at once, or lacks the time."""

from itertools import product

import numpy as np

from core.stl import to_text
from core.task.feasibility.cores import minimal
from core.task.feasibility.finding import Finding, Severity
from core.task.feasibility.search import Search
from core.task.feasibility.wording import Wording

MOST_STARTS = 27
"""Starts of which the share that lacks time is told."""


def start_findings(plan: Search, starts: np.ndarray) -> list[Finding]:
    """Shares of the initial set from which the formula cannot be satisfied as planned.

    Args:
        plan: has a solution from some start.
        starts: positions [P, d] of the initial set, its extremes included [m].
    """
    geometry, holds = plan.conflicts.geometry, plan.conflicts.obligations.holds
    inside = np.ones(len(starts), bool)
    found = []
    for predicate in dict.fromkeys(holds[i].predicate for i in plan.conflicts.company(0)[1:]):
        margin = geometry.margins_of(predicate, starts)
        outside = margin < -geometry.places.tolerance
        inside &= margin > 4 * geometry.places.tolerance  # the rest says nothing of ways
        if outside.any():
            words = (
                f"about {_share(outside)} of the initial set contradicts the formula: "
                f"{to_text(predicate)} must hold from step 0"
            )
            found.append(Finding(Severity.WARNING, words, (to_text(predicate),)))
    return found + _late(plan, starts[inside])


def _late(plan: Search, starts: np.ndarray) -> list[Finding]:
    """From which of the starts there is too little time, if from any."""
    if not len(starts):
        return []
    extremes = np.unique((starts @ _corners(starts)).argmax(0))
    worst = next((k for k in extremes if not _single(plan, starts[k]).possible()), None)
    if worst is None:
        return []
    tried = starts[
        np.linspace(0, len(starts) - 1, min(len(starts), MOST_STARTS)).round().astype(int)
    ]
    late = np.array([not _single(plan, start).possible() for start in tried])
    search = _single(plan, starts[worst])
    core = minimal(search, tuple(range(len(search.conflicts.obligations.holds))))
    wording = Wording(search, Severity.WARNING, starts[worst][None])
    words = f"from about {_share(late)} of the initial set, {wording.of(core)}"
    return [Finding(Severity.WARNING, words, wording.names(core))]


def _corners(starts: np.ndarray) -> np.ndarray:
    """Directions [d, 2^d] in which the initial set is looked at first."""
    return np.array(list(product((-1.0, 1.0), repeat=starts.shape[1]))).T


def _single(plan: Search, start: np.ndarray) -> Search:
    """The same search from a single start [d]."""
    return Search(plan.conflicts.beginning_at(start), plan.travel)


def _share(of_starts: np.ndarray) -> str:
    """`44%`; never 0% for some, nor 100% for not all."""
    share = float(of_starts.mean())
    if share < 1:
        share = min(max(share, 0.01), 0.99)
    return f"{share:.0%}"
