"""What the printer writes can be read back."""

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from core.stl import Atom, Formula, Interval, Until, parse, quote_name, to_math, to_text
from tests.strategies import ATOMS, formulas

AWKWARD_NAMES = [
    *("F", "G", "U", "H", "s", "ms", "true", "False", "not", "AND", "or", "implies", "until"),
    *("eventually", "Always", "A_1", "A_{1}", "F_", "_a", "1a", "a b", "", " ", "a-b", "é", "()"),
    *('say "x"', "it's", "back\\slash", "two\nlines", "\\", "¬", "◇", "U_[0:1]", "\u200b", "A\t"),
]


@pytest.mark.parametrize(
    ("text", "math"),
    [
        (
            "F_[0:90](A) & G_[0:100](!B) & (!D1)U_[0:100](K1)",
            "◇[0,90](A) ∧ □[0,100](¬B) ∧ (¬D1)U[0,100](K1)",
        ),
        ("A -> B | C & !D", "A → B ∨ C ∧ ¬D"),
        ("(A -> B) -> (C | D) & true", "(A → B) → (C ∨ D) ∧ ⊤"),
        ("!(A & B) | !F_[0:1](false)", "¬(A ∧ B) ∨ ¬◇[0,1](⊥)"),
        ("!((A)U_[0:1](B))", "¬((A)U[0,1](B))"),
        ("((A)U_[0:1](B))U_[2:3](C -> D)", "((A)U[0,1](B))U[2,3](C → D)"),
        ("(A & B) & C | (D | E)", "(A ∧ B) ∧ C ∨ (D ∨ E)"),
        ('"the lobby" & F_[70:80](F)', '"the lobby" ∧ ◇[70,80](F)'),
    ],
)
def test_canonical_texts(text, math):
    formula = parse(text)
    assert to_text(formula) == text
    assert to_math(formula) == math


@settings(deadline=None, max_examples=300)
@given(formulas(max_depth=4, atoms=("A", "F", "G", "U", "A_1", "not", "a b")))
def test_round_trip(formula: Formula):
    assert parse(to_text(formula)) == formula
    assert parse(to_math(formula)) == formula


@pytest.mark.parametrize("name", [name for name in AWKWARD_NAMES if name])
def test_awkward_names_survive(name):
    formula = Until(Interval(0, 1), Atom(name), Atom(name))
    assert parse(to_text(formula)) == formula
    assert parse(to_text(formula), names=[name, "A1"]) == formula


@settings(deadline=None)
@given(st.text(min_size=1, max_size=12))
@example("A_{x}")
def test_any_name_survives(name):
    assert parse(quote_name(name)) == Atom(name)


def test_only_names_that_need_them_get_quotes():
    for name in (*ATOMS, "F", "G", "U", "s", "goal_left", "B12", "room_1_2", "Notes", "Küche"):
        assert quote_name(name) == name
    for name in ("not", "True", "A_1", "a b", "1", "_a", "eventually", 'x"'):
        assert quote_name(name) != name
