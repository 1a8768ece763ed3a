"""The sentences: those of the shipped tasks as a person reads them, and all of them read back."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.stl import (
    Always,
    Eventually,
    Until,
    atom_names,
    horizon,
    parse,
    quote_name,
    robustness,
    sentences,
    walk,
)
from scenes import load_task, robot_of, scene_formula, task_names
from tests.core.stl.english_reader import read_english
from tests.strategies import ATOMS, formulas, nested_formulas, traces

FORMULAS = formulas(max_depth=4) | nested_formulas(max_depth=5)


def expected_of_tasks() -> dict[str, list[str]]:
    """By task, the sentences checked against its formula by hand."""
    expected: dict[str, list[str]] = {}
    text = Path(__file__).with_name("english.txt").read_text("utf-8")
    for block in text.strip().split("\n\n"):
        task, *lines = block.split("\n")
        expected[task] = lines
    return expected


TASKS = expected_of_tasks()


def test_every_shipped_task_has_its_sentences():
    assert sorted(TASKS) == task_names() and len(TASKS) == 50


@pytest.mark.parametrize("task", TASKS)
def test_the_sentences_of_the_shipped_tasks(task):
    scene = load_task(task)
    assert list(sentences(scene_formula(scene), robot_of(scene).dt)) == TASKS[task]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("A", "At 0 s be in A."),
        ("!A", "At 0 s be outside A."),
        ("true", "At 0 s be anywhere."),
        ("F_[20:20](A)", "At 4 s be in A."),
        ("F_[5:10](A & !B)", "Between 1 s and 2 s be in A and outside B."),
        ("!F_[0:5](A)", "From 0 s to 1 s stay outside A."),
        ("!G_[0:5](A | B)", "Between 0 s and 1 s be outside A and outside B."),
        ("!F_[0:5](G_[0:5](A))", "Never do (between 0 s and 1 s stay 1 s in A)."),
        ("F_[0:10](F_[0:0](A))", "Between 0 s and 2 s at that moment be in A."),
        (
            "G_[0:60](A -> F_[0:30](B))",
            "At every moment from 0 s to 12 s: if in A then 0 to 6 s later be in B.",
        ),
        ("G_[0:50](F_[5:10](A))", "At every moment from 0 s to 10 s: 1 to 2 s later be in A."),
        ("A -> F_[0:30](B)", "If in A at 0 s then between 0 s and 6 s be in B."),
        (
            "F_[0:5](A) -> G_[5:10](B)",
            "If this is done (between 0 s and 1 s be in A) then from 1 s to 2 s stay in B.",
        ),
        (
            "(!A) U_[5:10] B",
            "Stay outside A up to and including a moment between 1 s and 2 s, "
            "and then, at that moment, be in B.",
        ),
        (
            "!((!A) U_[5:10] B)",
            "Never do (stay outside A up to and including a moment between 1 s and 2 s, "
            "and then, at that moment, be in B).",
        ),
        (
            "F_[0:5]((F_[0:5](A)) U_[10:10] (B & G_[5:10](C)))",
            "Between 0 s and 1 s at every moment up to and including the moment 2 s later do "
            "(0 to 1 s later be in A), and then, at that moment, be in B, and from 1 to 2 s later "
            "stay in C.",
        ),
        (
            "F_[0:5](A) | G_[0:5](B)",
            "Do at least one of (between 0 s and 1 s be in A; from 0 s to 1 s stay in B).",
        ),
        (
            "F_[5:20](A & F_[0:5](B) & F_[5:10](C))",
            "Between 1 s and 4 s do all of (be in A; 0 to 1 s later be in B; 1 to 2 s later be "
            "in C).",
        ),
        ("G_[0:5](A <-> B)", "From 0 s to 1 s stay in A exactly when in B."),
        ("G_[0:5](A xor B)", "From 0 s to 1 s stay either in A or in B but not both."),
        (
            "F_[0:5](A) <-> F_[0:5](B)",
            "Do both or neither of (between 0 s and 1 s be in A; between 0 s and 1 s be in B).",
        ),
        ("F_[0:5]((A & B) | C)", "Between 0 s and 1 s be (in A and in B) or in C."),
        ('F_[0:5]("the lobby")', 'Between 0 s and 1 s be in "the lobby".'),
    ],
)
def test_a_sentence(text, said):
    assert sentences(parse(text), 0.2) == (said,)


def test_one_sentence_for_each_conjunct():
    formula = parse("F_[0:5](A) & (G_[0:5](B) & !C) & (A | F_[0:5](B))")
    assert len(sentences(formula, 0.2)) == 4


@pytest.mark.parametrize(
    ("dt", "said"),
    [
        (None, "Between step 1 and step 5 be in A, and 1 step later stay 2 steps in B."),
        (0.05, "Between 0.05 s and 0.25 s be in A, and 0.05 s later stay 0.1 s in B."),
        (2.0, "Between 2 s and 10 s be in A, and 2 s later stay 4 s in B."),
        (1 / 3, "Between step 1 and step 5 be in A, and 1 step later stay 2 steps in B."),
    ],
)
def test_times_are_seconds_unless_these_are_long_numbers(dt, said):
    assert sentences(parse("F_[1:5](A & F_[1:1](G_[0:2](B)))"), dt) == (said,)


@settings(deadline=None, max_examples=400)
@given(FORMULAS, st.data())
def test_sentences_read_back_mean_the_formula(formula, data):
    again = read_english(sentences(formula))
    length = max(horizon(formula), horizon(again)) + 1
    margins = data.draw(traces(length, batch=(8,), ties=False))
    for trace in margins:
        assert robustness(again, trace, ATOMS) == robustness(formula, trace, ATOMS)


def test_times_after_step_0_count_from_it():
    said = sentences(parse("F_[0:0](A & G_[0:1](B))"))
    assert said == ("At step 0 be in A, and stay 1 step in B.",)
    assert read_english(said) == parse("A & G_[0:1](B)")


def test_another_formula_does_not_read_back_as_this_one():
    formula, other = parse("F_[0:20](A & F_[5:9](B))"), parse("F_[0:20](A & F_[5:8](B))")
    assert read_english(sentences(formula)) == formula != other


@settings(deadline=None, max_examples=200)
@given(FORMULAS)
def test_the_sentences_name_every_atom_and_every_bound(formula):
    said = " ".join(sentences(formula))
    for name in atom_names(formula):
        assert re.search(rf"\b{quote_name(name)}\b", said)
    for node in walk(formula):
        if isinstance(node, Eventually | Always | Until):
            for bound in node.interval:
                assert bound == 0 or re.search(rf"\b{bound}\b", said)
