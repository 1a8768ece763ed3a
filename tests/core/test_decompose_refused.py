"""Formulas that cannot be decomposed, and what is said about them."""

import pytest

from core.decompose import (
    DecompositionError,
    decompose,
)
from core.errors import UserError
from core.stl import Always, And, Atom, Interval, Until, parse, to_text

REFUSED = {
    "F_[0:3](A & false)": ("F_[0:3](A & false)", "never hold"),
    "!((true)U_[0:3](true))": ("!((true)U_[0:3](true))", "never hold"),
    "G_[0:5000](F_[0:3](A))": ("G_[0:5000](F_[0:3](A))", "variables"),
    "C & G_[0:5000](A -> (!C)U_[0:3](G_[0:500](F_[0:3](D))))": (
        "G_[0:500](F_[0:3](D))",
        "variables",
    ),
}


@pytest.mark.parametrize("text", REFUSED)
def test_refusals_name_the_subformula(text: str):
    subformula, reason = REFUSED[text]
    with pytest.raises(DecompositionError) as caught:
        decompose(parse(text))
    assert f"`{to_text(parse(subformula))}`" in str(caught.value)
    assert reason in str(caught.value)


@pytest.mark.parametrize(
    "text", ["C & G_[0:999](A U_[0:2] B)", "C & (D U_[0:3] G_[0:999](A U_[0:2] B))"]
)
def test_refusals_give_the_columns_of_the_subformula(text: str):
    with pytest.raises(DecompositionError) as caught:
        decompose(parse(text))
    span = caught.value.span
    assert span is not None
    assert text[span.start : span.stop] == "G_[0:999](A U_[0:2] B)"
    assert f"(columns {span.start + 1}-{span.stop})" in str(caught.value)


def test_refusals_of_long_formulas_are_short_and_printable():
    names = [f"very_long_name_{index}" for index in range(300)] + ["a\x1b[31m"]
    until = Until(Interval(0, 2), And(tuple(map(Atom, names))), Atom("B"))
    with pytest.raises(DecompositionError) as caught:
        decompose(Always(Interval(0, 999), until))
    assert str(caught.value).isprintable() and len(str(caught.value)) < 400


def test_refusals_of_formulas_without_a_source_text_give_no_columns():
    until = Until(Interval(0, 2), Atom("A"), Atom("B"))
    with pytest.raises(DecompositionError) as caught:
        decompose(Always(Interval(0, 999), until))
    assert "columns" not in str(caught.value)
    assert f"`{to_text(Always(Interval(0, 999), until))}`" in str(caught.value)


def test_fewer_visits_than_the_least_are_refused():
    with pytest.raises(UserError, match="visits_extra is -1; it must be 0 or more"):
        decompose(parse("A"), visits_extra=-1)
