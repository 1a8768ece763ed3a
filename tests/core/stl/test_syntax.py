"""The syntax tree itself."""

import pytest
from hypothesis import given

from core.stl import (
    Always,
    And,
    Atom,
    Constant,
    Eventually,
    Interval,
    Not,
    Or,
    Span,
    Until,
    atom_names,
    conjunction,
    disjunction,
    horizon,
    is_state_formula,
    parse,
    walk,
)
from tests.strategies import formulas, state_formulas

A, B = Atom("A"), Atom("B")


@pytest.mark.parametrize("node", [And, Or])
@pytest.mark.parametrize("operands", [(), (A,)])
def test_a_junction_needs_two_operands(node, operands):
    with pytest.raises(ValueError, match="at least two operands"):
        node(operands)


def test_junctions_of_any_number_of_operands():
    assert conjunction([]) == Constant(True)
    assert disjunction([]) == Constant(False)
    assert conjunction([A]) == disjunction([A]) == A
    assert conjunction([A, B], span=Span(1, 2)).span == Span(1, 2)
    assert disjunction(iter([A, B])) == Or((A, B))


def test_spans_do_not_matter_to_equality():
    assert Atom("A", span=Span(0, 1)) == A
    assert hash(Atom("A", span=Span(0, 1))) == hash(A)


def test_atom_names_in_order_of_appearance():
    assert atom_names(parse("(B)U_[0:1](A) & F_[0:2](B | C)")) == ("B", "A", "C")


@pytest.mark.parametrize(
    ("text", "steps"),
    [
        ("A & true", 0),
        ("F_[2:5](A)", 5),
        ("F_[2:5](G_[0:7](A)) & G_[0:9](B)", 12),
        ("(F_[1:2](A))U_[0:3](G_[4:4](B))", 7),
    ],
)
def test_horizon(text, steps):
    assert horizon(parse(text)) == steps


@given(state_formulas())
def test_state_formulas_have_no_horizon(formula):
    assert is_state_formula(formula)
    assert horizon(formula) == 0


@given(formulas())
def test_walk_meets_every_temporal_operator(formula):
    temporal = [node for node in walk(formula) if isinstance(node, Eventually | Always | Until)]
    assert is_state_formula(formula) == (not temporal)
    assert not is_state_formula(Not(Eventually(Interval(0, 1), formula)))
