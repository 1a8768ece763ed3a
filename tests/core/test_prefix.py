"""What the beginning of a trace decides, against the semantics themselves."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.monitor import falsified_at
from core.stl import TraceError, horizon, parse, robustness
from tests.strategies import formulas

NAMES = ("A", "B", "C")


@settings(deadline=None, max_examples=200)
@given(formulas(), st.integers(0, 2**32 - 1), st.integers(1, 12))
def test_a_prefix_falsifies_if_and_only_if_no_signals_save_it(formula, seed, known):
    random = np.random.default_rng(seed)
    steps = max(horizon(formula) + 1, known)
    trace = random.uniform(-1, 1, (steps, len(NAMES)))
    step = falsified_at(formula, trace[:known], NAMES)
    free = np.concatenate([trace[:known], np.zeros((steps - known, len(NAMES)))])
    assert (step is None) == (robustness(formula, free, NAMES) >= 0)
    if step is None:
        return
    assert step < known
    assert falsified_at(formula, trace[: step + 1], NAMES) == step
    assert step == 0 or falsified_at(formula, trace[:step], NAMES) is None
    assert robustness(formula, trace, NAMES) < 0


def test_bad_margins_are_refused():
    with pytest.raises(TraceError, match="A"):
        falsified_at(parse("F_[0:3](A)"), np.zeros((2, 1)), ["B"])
