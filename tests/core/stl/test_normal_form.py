"""Normal forms keep the meaning and have the promised shape."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.stl import (
    Atom,
    Constant,
    Implies,
    Not,
    Until,
    fold_constants,
    horizon,
    negation_normal_form,
    parse,
    robustness_signal,
    to_text,
    walk,
)
from tests.strategies import ATOMS, formulas, traces


@settings(deadline=None, max_examples=200)
@given(formulas(), st.data())
def test_negation_normal_form_keeps_robustness(formula, data):
    margins = data.draw(traces(horizon(formula) + 3, batch=(4,)))
    normal = negation_normal_form(formula)
    expected = robustness_signal(formula, margins, ATOMS)
    np.testing.assert_array_equal(robustness_signal(normal, margins, ATOMS), expected)


@given(formulas(max_depth=4))
def test_shape_of_the_negation_normal_form(formula):
    normal = negation_normal_form(formula)
    for node in walk(normal):
        assert not isinstance(node, Implies)
        assert not isinstance(node, Not) or isinstance(node.operand, Atom | Until)
    assert negation_normal_form(normal) == normal


@settings(deadline=None, max_examples=200)
@given(formulas(max_depth=4), st.data())
def test_folding_constants_keeps_robustness(formula, data):
    margins = data.draw(traces(horizon(formula) + 1, batch=(4,)))
    folded = fold_constants(formula)
    expected = robustness_signal(formula, margins, ATOMS)[..., 0]
    np.testing.assert_array_equal(robustness_signal(folded, margins, ATOMS)[..., 0], expected)


@given(formulas(max_depth=4))
def test_folding_leaves_no_constant_below_the_root(formula):
    folded = fold_constants(formula)
    assert isinstance(folded, Constant) or not any(isinstance(n, Constant) for n in walk(folded))


@pytest.mark.parametrize(
    ("text", "normal"),
    [
        ("!(A & B | C)", "(!A | !B) & !C"),
        ("!(A -> B)", "A & !B"),
        ("A -> B", "!A | B"),
        ("!F_[1:2](A & !B)", "G_[1:2](!A | B)"),
        ("!G_[1:2](!!A)", "F_[1:2](!A)"),
        ("!((A -> B)U_[0:3](!!C))", "!((!A | B)U_[0:3](C))"),
        ("!!((A)U_[0:3](B))", "(A)U_[0:3](B)"),
        ("!true | !false", "false | true"),
    ],
)
def test_negation_normal_forms(text, normal):
    assert to_text(negation_normal_form(parse(text))) == normal


@pytest.mark.parametrize(
    ("text", "folded"),
    [
        ("A & true & B", "A & B"),
        ("A & !false", "A"),
        ("A & false", "false"),
        ("A | true", "true"),
        ("false | A", "A"),
        ("true -> A", "A"),
        ("A -> false", "!A"),
        ("A -> !!true", "true"),
        ("F_[0:3](A | true)", "true"),
        ("(true)U_[1:3](A)", "F_[1:3](A)"),
        ("(A)U_[2:3](true)", "G_[0:2](A)"),
        ("(A)U_[2:3](false)", "false"),
    ],
)
def test_folded_formulas(text, folded):
    assert to_text(fold_constants(parse(text))) == folded


def test_nodes_of_the_normal_form_know_their_source():
    text = "A & !F_[0:3](B -> C)"
    normal = negation_normal_form(parse(text))
    spans = {to_text(node): text[slice(*node.span)] for node in walk(normal) if node.span}
    assert spans["G_[0:3](B & !C)"] == "!F_[0:3](B -> C)"
    assert spans["B & !C"] == "B -> C"
