"""Simplified formulas keep the meaning, and have no window of one step that is not needed."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.stl import (
    Always,
    Eventually,
    Until,
    fold_constants,
    horizon,
    negation_normal_form,
    parse,
    robustness_signal,
    simplify,
    to_text,
    walk,
)
from tests.strategies import ATOMS, formulas, traces


@settings(deadline=None, max_examples=300)
@given(formulas(max_depth=4), st.data())
def test_simplifying_keeps_robustness_and_horizon(formula, data):
    normal = negation_normal_form(fold_constants(formula))
    simple = simplify(normal)
    assert horizon(simple) == horizon(normal)
    margins = data.draw(traces(horizon(formula) + 3, batch=(4,)))
    expected = robustness_signal(normal, margins, ATOMS)
    np.testing.assert_array_equal(robustness_signal(simple, margins, ATOMS), expected)


@given(formulas(max_depth=4))
def test_shape_of_the_simplified_form(formula):
    simple = simplify(negation_normal_form(fold_constants(formula)))
    for node in walk(simple):
        if isinstance(node, Eventually | Until):
            assert node.interval.start < node.interval.stop
        for kind in (Eventually, Always):
            assert not (isinstance(node, kind) and isinstance(node.operand, kind))
    assert simplify(simple) == simple
    assert negation_normal_form(simple) == simple


@pytest.mark.parametrize(
    ("text", "simple"),
    [
        ("F_[3:3](A)", "G_[3:3](A)"),
        ("F_[1:2](F_[3:5](A))", "F_[4:7](A)"),
        ("G_[1:2](G_[3:5](A))", "G_[4:7](A)"),
        ("G_[0:20](F_[1:1](A))", "G_[1:21](A)"),
        ("G_[0:1000000](F_[0:0](A))", "G_[0:1000000](A)"),
        ("F_[2:2](F_[0:3](A))", "F_[2:5](A)"),
        ("F_[0:3](F_[2:2](A))", "F_[2:5](A)"),
        ("(A)U_[2:2](B)", "G_[0:2](A) & G_[2:2](B)"),
        ("!((A)U_[2:2](B))", "F_[0:2](!A) | G_[2:2](!B)"),
        ("G_[0:0](F_[0:3](A))", "F_[0:3](A)"),
        ("G_[0:0](A) & F_[0:3](G_[0:3](A))", "G_[0:0](A) & F_[0:3](G_[0:3](A))"),
    ],
)
def test_simplified_formulas(text, simple):
    assert to_text(simplify(negation_normal_form(parse(text)))) == simple
