"""Chains of visits for G_[0:length] F_[0:width-1] A, tried on every trace."""

import itertools

import numpy as np
import pytest

from core.decompose import decompose, enough_visits, least_visits
from core.stl import Always, Atom, Eventually, Formula, Interval
from tests.core.decompose_oracle import all_schedules

SIZES = [(length, width) for length in range(8) for width in range(1, 5) if length + width <= 9]


def recurrence(length: int, width: int) -> Formula:
    return Always(Interval(0, length), Eventually(Interval(0, width - 1), Atom("A")))


def satisfying(length: int, width: int) -> np.ndarray:
    """All Boolean traces [N, T] with a visit in each window of `width` steps."""
    traces = np.array(list(itertools.product([False, True], repeat=length + width)))
    windows = [traces[:, t : t + width].any(1) for t in range(length + 1)]
    return traces[np.all(windows, axis=0)]


def planned(formula: Formula, extra: int) -> list[list[int]]:
    """The steps that each schedule visits."""
    plan = decompose(formula, visits_extra=extra)
    return [
        [start for _, start, _ in plan.active_tasks(tuple(row))]
        for row in all_schedules(plan).tolist()
    ]


def fulfilled(traces: np.ndarray, plans: list[list[int]]) -> np.ndarray:
    """Whether some plan finds a visit at each of its steps, for every trace [N]."""
    return np.any([traces[:, plan].all(1) for plan in plans], axis=0)


@pytest.mark.parametrize(("length", "width"), SIZES)
def test_enough_visits_are_enough_and_one_less_is_not(length: int, width: int):
    formula, traces = recurrence(length, width), satisfying(length, width)
    missing = enough_visits(length, width) - least_visits(length, width)
    assert decompose(formula).visits_missing == missing
    assert fulfilled(traces, planned(formula, missing)).all()
    assert fulfilled(traces, planned(formula, missing + 1)).all()
    if missing:
        assert not fulfilled(traces, planned(formula, missing - 1)).all()


@pytest.mark.parametrize(("length", "width"), SIZES)
def test_least_visits_are_those_of_the_laziest_trace(length: int, width: int):
    formula, traces = recurrence(length, width), satisfying(length, width)
    fewest = traces.sum(1).min()
    plans = planned(formula, 0)
    # Windows of one step are a stay, which has no visits.
    assert {len(plan) for plan in plans} == {fewest if width > 1 else 1}
    if width == 1:
        return
    laziest = traces[traces.sum(1) == fewest]
    assert fulfilled(laziest, plans).all()
    assert all(traces[:, plan].all(1).any() for plan in plans), "a plan that satisfies nothing"


def test_few_visits_miss_an_irregular_trace():
    """Visits at 0, 3 and 4 with windows of 3 steps: two visits cannot cover them."""
    trace = np.array([[True, False, False, True, True, False, False]])
    formula = recurrence(4, 3)
    assert least_visits(4, 3) == 2
    assert not fulfilled(trace, planned(formula, 0)).any()
    assert fulfilled(trace, planned(formula, 1)).all()


def test_domains_hold_no_value_that_no_chain_can_use():
    for (length, width), extra in itertools.product(SIZES, (0, 1)):
        plan = decompose(recurrence(length, width), visits_extra=extra)
        used = all_schedules(plan)
        assert used.min(0).tolist() == [variable.low for variable in plan.variables]
