"""Some schedule makes every task hold on the trace iff the trace satisfies the formula.

Checked in the stronger, quantitative form: the best value over all schedules *is* the robustness.
For G(F) with few visits it is a lower bound, and it is the robustness with enough visits.
"""

import random
from collections import Counter

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from core.decompose import decompose
from core.stl import Formula, horizon
from tests.core.decompose_oracle import (
    ATOMS,
    all_schedules,
    best_value,
    features,
    random_formula,
    random_trace,
    schedule_count,
)
from tests.core.stl.reference import reference_robustness

MOST_SCHEDULES = 20_000
TRACES = 3
FEATURES = (
    "disjunction",
    "until",
    "nested until",
    "negated until",
    "recurrence",
    "response",
    "lockout",
    "until at every step",
    "until when due",
    "until due later",
)


@st.composite
def coverable(draw: st.DrawFn) -> Formula:
    return random_formula(lambda low, high: draw(st.integers(low, high)), 3)


def small(formula: Formula) -> bool:
    """Whether the schedules of a formula with enough visits can all be tried."""
    plan = decompose(formula)
    return schedule_count(plan) <= MOST_SCHEDULES and (
        schedule_count(decompose(formula, visits_extra=plan.visits_missing)) <= MOST_SCHEDULES
    )


def check(formula: Formula, rng: np.random.Generator) -> float:
    """Assert the theorem on one random trace; its robustness."""
    trace = random_trace(rng, horizon(formula) + 1)
    expected = reference_robustness(formula, trace, ATOMS)
    plan = decompose(formula)
    fewest = best_value(plan, trace)
    enough = fewest
    if plan.visits_missing:
        complete = decompose(formula, visits_extra=plan.visits_missing)
        assert complete.visits_missing == 0
        enough = best_value(complete, trace)
    assert fewest <= expected
    assert enough <= expected
    if not plan.one_sided:
        assert (enough >= 0) == (expected >= 0)
        assert enough == expected
    return expected


@settings(
    max_examples=300,
    deadline=None,
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)
@given(formula=coverable(), seed=st.integers(0, 2**32 - 1))
def test_best_schedule_is_the_robustness(formula: Formula, seed: int):
    assume(small(formula))
    rng = np.random.default_rng(seed)
    for _ in range(TRACES):
        check(formula, rng)


def test_generated_cases_cover_every_construct_and_both_verdicts():
    choices, rng = random.Random(11), np.random.default_rng(11)
    verdicts: Counter[tuple[str, bool]] = Counter()
    for _ in range(2000):
        formula = random_formula(choices.randint, 3)
        if not small(formula):
            continue
        expected = check(formula, rng)
        verdicts["all", expected >= 0] += 1
        for feature in features(formula):
            verdicts[feature, expected >= 0] += 1
    for satisfied in (True, False):
        assert verdicts["all", satisfied] >= 300
        for feature in FEATURES:
            assert verdicts[feature, satisfied] >= 20, feature


@pytest.mark.parametrize("extra", [0, 1])
def test_enumeration_agrees_with_the_definition(extra: int):
    choices, checked = random.Random(5), 0
    for _ in range(1000):
        plan = decompose(random_formula(choices.randint, 2), visits_extra=extra)
        if schedule_count(plan) > 300 or not plan.requirements:
            continue
        expected = [tuple(row) for row in all_schedules(plan).tolist()]
        assert list(plan.schedules()) == expected
        assert schedule_count(plan) >= len(expected) > 0
        checked += 1
    assert checked >= 30
