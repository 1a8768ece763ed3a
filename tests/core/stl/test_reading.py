"""Robustness depends on the samples that the formula reads, and on nothing else."""

from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.stl import (
    horizon,
    parse,
    robustness,
    robustness_signal,
    samples_read,
    satisfied,
    smooth_robustness,
)
from tests.core.stl.reference import reference_reads
from tests.strategies import ATOMS, formulas, nested_formulas, traces

FORMULAS = formulas(max_depth=3, max_bound=3) | nested_formulas(max_depth=4, max_bound=3)
BROKEN = [np.nan, np.inf, -np.inf]


@pytest.mark.parametrize("library", [np, jnp])
def test_a_sample_beyond_the_window_of_an_until_has_no_influence(library):
    formula = parse("F_[0:5](A) & (C)U_[0:1](B)")
    margins = np.ones((6, 3))
    margins[5, 1] = np.nan
    assert robustness(formula, library.asarray(margins), ATOMS) == 1.0
    assert satisfied(formula, library.asarray(margins), ATOMS)
    smooth = smooth_robustness(formula, library.asarray(margins), ATOMS, 0.1)
    assert smooth == smooth_robustness(formula, library.ones((6, 3)), ATOMS, 0.1)


@settings(deadline=None, max_examples=300)
@given(FORMULAS, st.integers(0, 3))
def test_the_samples_read_are_those_of_the_definition(formula, spare):
    length = horizon(formula) + 1 + spare
    read = samples_read(formula, length, ATOMS)
    np.testing.assert_array_equal(read, reference_reads(formula, ATOMS, length))


@settings(deadline=None, max_examples=300)
@given(FORMULAS, st.sampled_from(BROKEN), st.data())
def test_what_is_not_read_has_no_influence(formula, number, data):
    length = horizon(formula) + 1 + data.draw(st.integers(0, 3))
    margins = data.draw(traces(length))
    expected = robustness_signal(formula, margins, ATOMS)
    smooth = smooth_robustness(formula, margins, ATOMS, 0.3)
    for step in range(length - horizon(formula)):
        read = reference_reads(formula, ATOMS, length, step)
        broken = np.where(read, margins, number)
        assert robustness_signal(formula, broken, ATOMS)[step] == expected[step]
    broken = np.where(reference_reads(formula, ATOMS, length), margins, number)
    assert robustness(formula, broken, ATOMS) == expected[0]
    assert satisfied(formula, broken, ATOMS) == (expected[0] >= 0)
    assert smooth_robustness(formula, broken, ATOMS, 0.3) == smooth


NESTED = "F_[0:3]((A)U_[1:4](G_[0:1](B))) & (F_[1:2](C))U_[2:4](A) & G_[0:9](C)"


@pytest.mark.parametrize("function", [robustness, partial(smooth_robustness, temperature=0.3)])
def test_neither_has_it_in_jax_nor_on_gradients(function):
    formula = parse(NESTED)
    length = horizon(formula) + 2
    margins = np.random.default_rng(9).normal(size=(length, len(ATOMS)))
    read = reference_reads(formula, ATOMS, length)
    assert (~read).sum() == 7
    evaluated = jax.jit(jax.value_and_grad(lambda trace: function(formula, trace, ATOMS)))
    expected, found = evaluated(margins), evaluated(np.where(read, margins, np.nan))
    np.testing.assert_array_equal(expected[0], found[0])
    np.testing.assert_array_equal(expected[1], found[1])
    assert np.count_nonzero(found[1]) and not np.asarray(found[1])[~read].any()


@settings(deadline=None, max_examples=200)
@given(FORMULAS, st.data())
def test_nan_in_a_sample_that_is_read_satisfies_nothing(formula, data):
    length = horizon(formula) + 1
    margins, read = data.draw(traces(length)), reference_reads(formula, ATOMS, length)
    for sample in np.argwhere(read)[:: max(1, read.sum() // 5)]:
        broken = margins.copy()
        broken[tuple(sample)] = np.nan
        assert np.isnan(robustness(formula, broken, ATOMS))
        assert not satisfied(formula, broken, ATOMS)
