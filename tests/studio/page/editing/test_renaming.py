"""A region gets another name, and so does the formula."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.stl import Atom, parse, quote_name, to_text, walk
from scenes import load_task
from studio.page.editing.document import Document
from studio.page.editing.renaming import rename_in_formula
from tests.strategies import formulas
from tests.studio.page.editing.draft import DT, scene


def test_rename_changes_the_formula_and_nothing_else_in_it(document):
    document.rename("A1", "the lobby")
    assert document.scene.formula == 'F_[0:10]("the lobby") &  G_[0:20]( !B )'
    assert document.scene.region_names == ("the lobby", "B", "C")
    document.rename("the lobby", "goal")
    assert document.scene.formula == "F_[0:10](goal) &  G_[0:20]( !B )"
    assert document.undo() == "rename the lobby to goal"
    assert document.undo() == "rename A1 to the lobby"
    assert document.scene == scene()


@pytest.mark.parametrize(
    ("text", "old", "new", "expected"),
    [
        ("F_[70:80](F) & G_[0:9](!F)", "F", "K", "F_[70:80](K) & G_[0:9](!K)"),
        ("F_[0:1](A) & A1 | AA", "A", "Z", "F_[0:1](Z) & A1 | AA"),
        ("F_[0:1](A)", "A", "F", "F_[0:1](F)"),
        ("F_[0:1](A)", "A", "and", 'F_[0:1]("and")'),
        ("not A", "A", "K", "not K"),
        ("A_1 & A_{1} & A1", "A1", "K", "K & K & K"),
        ("A_1U_[0:5]B", "A1", "goal", " goal U_[0:5]B"),
        ("'A'U_[0:5]\"A\"", "A", "x y", '"x y"U_[0:5]"x y"'),
        (r"\text{A} \land \neg A", "A", "K", r"K \land \neg K"),
        ("F_[0 s:0.4 s] A", "A", "K", "F_[0 s:0.4 s] K"),
        # The new name is what the formula already writes for another region.
        ("A_1 & C", "C", "A_1", 'A1 & "A_1"'),
        # Other dialects.
        ("F A & []<> A // A is home", "A", "K", "F K & []<> K // A is home"),
        ("A <-> F_[0:1] A", "A", "K", "K <-> F_[0:1] K"),
        ("Ｆ［0:1］（Ａ）", "A", "K", "Ｆ［0:1］（K）"),
        # Not formulas (yet): words and quotations.
        ("F_[0:1](A & ", "A", "K", "F_[0:1](K & "),
        ("F_[0:1](A & NEW)", "A", "K", "F_[0:1](K & NEW)"),
        ("F_[0:1](F & G_[2:1](A", "F", "K", "F_[0:1](K & G_[2:1](A"),
        ('A & "A" & "my A" & ', "A", "K L", '"K L" & "K L" & "my A" & '),
    ],
)
def test_renaming_in_text(text, old, new, expected):
    names = [name for name in ("A", "AA", "A1", "B", "C", "F") if name != new]
    assert rename_in_formula(text, old, new, names=names, dt=DT, horizon=9) == expected


@settings(max_examples=80, deadline=None)
@given(formulas(max_depth=3), st.sampled_from(["Z", "F", "U", "until", "x_1", "é", "1", "a b"]))
def test_renaming_renames_the_atoms_of_any_formula(formula, new):
    text = rename_in_formula(to_text(formula), "A", new, names=("A", "B", "C"), dt=None)
    found = parse(text, names=(new, "B", "C"))
    expected = [new if n == Atom("A") else getattr(n, "name", None) for n in walk(formula)]
    assert [getattr(node, "name", None) for node in walk(found)] == expected
    assert [type(node) for node in walk(found)] == [type(node) for node in walk(formula)]


def test_every_shipped_scene_can_be_edited_and_renamed():
    document = Document(load_task("linear-08"))
    document.rename("A1", "first goal")
    now = document.scene
    assert quote_name("first goal") in now.formula
    assert document.matches(load_task("linear-08"))
    assert now.formula.count("\n") == load_task("linear-08").formula.count("\n")
