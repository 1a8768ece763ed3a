"""The smooth robustness tends to the exact one and has useful, finite gradients."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.stl import (
    And,
    Formula,
    Or,
    TraceError,
    Until,
    children,
    horizon,
    negation_normal_form,
    parse,
    robustness,
    smooth_robustness,
)
from core.stl.syntax import Always, Eventually, Implies
from tests.strategies import ATOMS, formulas, traces

MIXED = "(A)U_[1:6](B & G_[0:2](!C)) & F_[2:9](A | C) & !(G_[0:3](C))"


def error_bound(formula: Formula, length: int) -> float:
    """Largest |smooth - exact| in temperatures: log-sum-exp of n values errs by at most log n."""
    inner = max((error_bound(child, length) for child in children(formula)), default=0.0)
    match formula:
        case And(operands=operands) | Or(operands=operands):
            return inner + math.log(len(operands))
        case Implies():
            return inner + math.log(2)
        case Eventually(interval=(a, b)) | Always(interval=(a, b)):
            return inner + math.log(b - a + 1)
        case Until():
            return inner + math.log(3) + 2 * length * math.log(2)
        case _:
            return inner


@settings(deadline=None, max_examples=150)
@given(formulas(), st.data())
def test_it_tends_to_the_exact_robustness(formula, data):
    length = horizon(formula) + 1
    margins = data.draw(traces(length, batch=(4,)))
    exact = robustness(formula, margins, ATOMS)
    for temperature in (1.0, 1e-2, 1e-6):
        smooth = smooth_robustness(formula, margins, ATOMS, temperature)
        tolerance = temperature * error_bound(formula, length) + 1e-9
        np.testing.assert_allclose(smooth, exact, rtol=0, atol=tolerance)


def test_windows_are_sums_over_each_step_once():
    margins = np.random.default_rng(0).normal(size=(17, 1))
    for start, stop in [(0, 16), (3, 3), (2, 9), (5, 16), (0, 3)]:
        formula = parse(f"F_[{start}:{stop}](A)")
        expected = 0.3 * np.log(np.exp(margins[start : stop + 1] / 0.3).sum())
        smooth = smooth_robustness(formula, margins, ["A"], 0.3)
        assert smooth == pytest.approx(expected, rel=1e-12)
    shifted = smooth_robustness(parse("F_[2:2](F_[0:4](A))"), margins, ["A"], 0.3)
    assert shifted == pytest.approx(0.3 * np.log(np.exp(margins[2:7] / 0.3).sum()), rel=1e-12)


@settings(deadline=None, max_examples=60)
@given(formulas(), st.data())
def test_negation_normal_form_keeps_the_smooth_robustness(formula, data):
    margins = data.draw(traces(horizon(formula) + 1, batch=(4,)))
    smooth = [
        smooth_robustness(each, margins, ATOMS, 0.1)
        for each in (formula, negation_normal_form(formula))
    ]
    np.testing.assert_allclose(*smooth, rtol=1e-9, atol=1e-12)


def test_the_gradient_matches_finite_differences():
    formula = parse(MIXED)
    margins = np.random.default_rng(2).normal(size=(horizon(formula) + 3, 3))

    def value(margins):
        return smooth_robustness(formula, margins, ATOMS, 0.5)

    smooth, gradient = jax.jit(jax.value_and_grad(value))(margins)
    assert smooth == pytest.approx(value(margins), abs=1e-5)
    differences = np.zeros_like(margins)
    for index in np.ndindex(*margins.shape):
        step = np.zeros_like(margins)
        step[index] = 1e-5
        differences[index] = (value(margins + step) - value(margins - step)) / 2e-5
    np.testing.assert_allclose(gradient, differences, atol=1e-5)
    assert np.count_nonzero(differences[: horizon(formula) + 1, 0]) >= 9
    np.testing.assert_array_equal(gradient[horizon(formula) + 1 :], 0.0)


def test_values_and_gradients_stay_finite():
    formula = parse(f"({MIXED}) & true & (A)U_[2:3](true) | F_[0:3](false)")
    margins = np.random.default_rng(4).normal(size=(20, 3))
    value_and_gradient = jax.jit(
        jax.value_and_grad(
            lambda margins, temperature: smooth_robustness(formula, margins, ATOMS, temperature)
        )
    )
    for temperature in (1e-6, 1e-2, 10.0):
        for scale in (1.0, 1e3):
            value, gradient = value_and_gradient(margins * scale, temperature)
            assert jnp.isfinite(value)
            assert jnp.isfinite(gradient).all()
            assert jnp.abs(gradient).sum() > 0.5


def test_the_temperature_may_be_traced():
    formula, margins = parse("F_[0:3](A)"), jnp.ones((4, 1))
    value = jax.jit(lambda t: smooth_robustness(formula, margins, ["A"], t))(0.5)
    assert value == pytest.approx(1 + 0.5 * math.log(4), rel=1e-6)


def test_constants_stay_infinite():
    assert smooth_robustness(parse("A | true"), np.ones((1, 1)), ["A"], 0.1) == np.inf
    assert smooth_robustness(parse("A & false"), jnp.ones((1, 1)), ["A"], 0.1) == -np.inf


@pytest.mark.parametrize("temperature", [0, -1.0, float("nan")])
def test_the_temperature_is_positive(temperature):
    with pytest.raises(ValueError, match="temperature must be positive"):
        smooth_robustness(parse("A"), np.ones((1, 1)), ["A"], temperature)


def test_a_short_trace_is_refused():
    with pytest.raises(TraceError, match="needs at least 4"):
        smooth_robustness(parse("F_[0:3](A | true)"), np.ones((3, 1)), ["A"], 0.1)
