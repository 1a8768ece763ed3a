"""The formula in English below the editor."""

import html
from dataclasses import replace

import pytest

from scenes import load_task
from studio.page.panels.english import MOST_SENTENCES, english_html
from tests.studio.conftest import EVIL

SCENE = load_task("linear-08")


def said(formula: str) -> str:
    return html.unescape(english_html(replace(SCENE, formula=formula)))


def test_a_sentence_for_each_conjunct():
    drawn = said(SCENE.formula)
    assert drawn.count("<li>") == 7
    assert "<li>Between 8 s and 16 s be in A2, and 2 to 4 s later stay 2 s in A3.</li>" in drawn
    assert "tg-note" not in drawn


def test_what_the_text_left_open_is_said_in_one_note():
    drawn = said("[]<>(A1) & F_[20] A2")
    assert drawn.count("tg-info") == 1
    assert "horizon, 100 steps, which nested operators share: G_[0:50], F_[0:50]." in drawn
    assert "the one step [20:20]" in drawn


def test_a_formula_that_does_not_decompose_is_read_back_too():
    assert "if in A1 then 0 to 4 s later be in A2" in said("G_[0:50](A1 -> F_[0:20](A2))")


@pytest.mark.parametrize("formula", ["F_[0:5](", "F_[0:5](NEW)", "x > 3"])
def test_nothing_is_said_of_what_cannot_be_read(formula):
    assert said(formula) == ""


def test_names_cannot_run_code(evil_scene):
    drawn = english_html(evil_scene)
    assert EVIL not in drawn
    assert html.escape(EVIL) in drawn


def test_very_many_conjuncts_are_counted():
    drawn = said(" & ".join(["A1"] * (MOST_SENTENCES + 7)))
    assert drawn.count("<li>") == MOST_SENTENCES
    assert "7 more" in drawn
