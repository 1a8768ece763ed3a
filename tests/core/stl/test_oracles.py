"""Robustness against two independent tools, rtamt and stljax, on generated formulas.

Their conventions differ from ours, and the comparison avoids the differences:

- rtamt's discrete until asks the left side before t' only, so that ours is
  `left until (right and left)` there; it knows no names such as F, G and H; beyond the end of the
  trace it takes a window for empty, hence we compare only where the trace decides the formula;
  it fails on traces of a single step.
- stljax works on one trace in single precision, and takes -1e9 beyond the end of the trace.
"""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
import rtamt
import stljax.formula as stljax
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from core.stl import (
    TraceError,
    horizon,
    parse,
    robustness,
    robustness_signal,
    satisfied,
)
from studio.bench.peers.translation import rtamt_text, stljax_formula
from tests.strategies import formulas, nested_formulas, traces

NAMES = ("F", "G", "H")
SLOW = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])


def rtamt_signal(text: str, trace: np.ndarray) -> np.ndarray:
    """Robustness [T] of a trace [T, A]."""
    specification = rtamt.StlDiscreteTimeOfflineSpecification()
    for name in NAMES:
        specification.declare_var(f"margin_{name}", "float")
    specification.spec = text
    specification.parse()
    columns = {f"margin_{name}": list(trace[:, index]) for index, name in enumerate(NAMES)}
    values = specification.evaluate({"time": list(range(len(trace))), **columns})
    return np.array([value for _, value in values])


@settings(SLOW, max_examples=400)
@given(
    formulas(max_depth=3, atoms=NAMES, max_bound=5, constants=False)
    | nested_formulas(max_depth=4, atoms=NAMES, max_bound=5, constants=False),
    st.data(),
)
def test_against_rtamt(formula, data):
    trace = data.draw(traces(horizon(formula) + 2 + data.draw(st.integers(0, 3)), NAMES))
    values = robustness_signal(formula, trace, NAMES)
    oracle = rtamt_signal(rtamt_text(formula), trace)[: len(values)]
    np.testing.assert_array_equal(values, oracle)


STLJAX_STEPS = 10


@settings(SLOW, max_examples=120)
@given(
    formulas(max_depth=2, atoms=NAMES, max_bound=3, constants=False)
    | nested_formulas(max_depth=3, atoms=NAMES, max_bound=3, constants=False),
    traces(STLJAX_STEPS, NAMES, batch=(4,), ties=False),
)
def test_against_stljax(formula, margins):
    margins = margins.astype(np.float32)
    decided = STLJAX_STEPS - horizon(formula)
    with jax.numpy_rank_promotion("allow"):
        oracle = jax.vmap(stljax_formula(stljax, formula, NAMES))(jnp.asarray(margins))[:, :decided]
    values = robustness_signal(formula, margins, NAMES)
    np.testing.assert_allclose(values, oracle, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(satisfied(formula, margins, NAMES), oracle[:, 0] > 0)


@settings(SLOW, max_examples=15)
@given(
    nested_formulas(max_depth=3, atoms=NAMES, max_bound=3, constants=False),
    traces(STLJAX_STEPS, NAMES, batch=(4,)),
)
def test_jax_against_rtamt(formula, margins):
    values = robustness_signal(formula, jnp.asarray(margins), NAMES)
    text = rtamt_text(formula)
    for trace, row in zip(margins, values, strict=True):
        np.testing.assert_array_equal(row, rtamt_signal(text, trace)[: row.shape[-1]])


def test_the_left_side_of_an_until_at_the_moment_of_the_right():
    """Without the translation rtamt would accept a key taken in the doorway; we do not."""
    formula = parse("(!F)U_[0:3](G)")
    trace = np.full((4, 3), -1.0)
    trace[2, :2] = 1.0
    exclusive = "((not (margin_F >= 0)) until[0,3] (margin_G >= 0))"
    assert rtamt_signal(exclusive, trace)[0] == 1.0
    assert rtamt_signal(rtamt_text(formula), trace)[0] == -1.0
    assert robustness(formula, trace, NAMES) == -1.0


def test_a_trace_that_ends_too_early_is_refused_not_guessed():
    formula = parse("F_[5:6](F)")
    trace = np.ones((3, 3), np.float32)
    assert np.isinf(rtamt_signal(rtamt_text(formula), trace)[0])
    with jax.numpy_rank_promotion("allow"):
        assert stljax_formula(stljax, formula, NAMES)(jnp.asarray(trace))[0] == -1e9
    with pytest.raises(TraceError, match="needs at least 7"):
        robustness(formula, trace, NAMES)
