"""What an explanation says is true of the trace, and of nothing but what the formula reads."""

import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from core.monitor import Signals, diagnose
from core.monitor.misses import Misses
from core.stl import (
    Always,
    And,
    Eventually,
    Formula,
    Not,
    Or,
    Until,
    fold_constants,
    horizon,
    is_state_formula,
    negation_normal_form,
    parse,
)
from tests.core.stl.reference import reference_reads, reference_robustness
from tests.strategies import ATOMS, formulas, nested_formulas, traces

FORMULAS = formulas(max_depth=3) | nested_formulas(max_depth=4, max_bound=3)
DT = 0.2
PLACE = re.compile(
    r"the robot was (outside|in) ([ABC]) (?:at|during|when)? ?steps? (\d+)(?:-(\d+))?"
)
NEVER = re.compile(r"([ABC]) was never (reached|left) between steps (\d+) and (\d+)")
HELD = re.compile(r"held until (.+) held at step (\d+)")
STEPS = re.compile(r"(?<!attempt \()steps? (\d+)(?:-(\d+)| and (\d+))?")


def columns(**signals) -> np.ndarray:
    """Margins [T, 3] of A, B and C from signs: `+` inside, `-` outside; outside if not given."""
    length = len(next(iter(signals.values())))
    texts = [signals.get(name, "-" * length) for name in ATOMS]
    return np.array([[1.0 if sign == "+" else -1.0 for sign in text] for text in texts]).T


def sentence(text: str, margins: np.ndarray) -> str:
    return diagnose(parse(text), margins, ATOMS, DT).sentence


def check(formula: Formula, margins: np.ndarray) -> str:
    """Assert that everything the explanation names is read, and is as it says; the sentence."""
    found = diagnose(formula, margins, ATOMS, DT)
    text = found.sentence
    read = reference_reads(formula, ATOMS, len(margins))
    assert not re.search(r"\b(true|false)\b", text)
    if found.step is not None:
        assert read[found.step].any()
    if found.atom is not None:
        column = ATOMS.index(found.atom)
        assert read[found.step, column]
        assert found.satisfied or margins[found.step, column] != 0
    for first, last, end in STEPS.findall(text):
        assert read[[int(step) for step in (first, last, end) if step]].any(axis=1).all()
    for side, name, first, last in PLACE.findall(text):
        steps, column = slice(int(first), int(last or first) + 1), ATOMS.index(name)
        assert read[steps, column].all()
        assert (margins[steps, column] * (1 if side == "in" else -1) > 0).all()
    for name, verb, first, last in NEVER.findall(text):
        steps, column = slice(int(first), int(last) + 1), ATOMS.index(name)
        assert read[steps, column].all()
        assert (margins[steps, column] * (1 if verb == "left" else -1) > 0).all()
    for goal, step in HELD.findall(text):
        if " ... " not in goal:
            right = parse(goal.rpartition(" held until ")[2] or goal)
            assert reference_robustness(right, margins, ATOMS, int(step)) > 0
    return text


@settings(max_examples=1000, deadline=None)
@given(FORMULAS, st.booleans(), st.data())
def test_what_an_explanation_names_is_read_and_as_it_says(formula, ties, data):
    check(
        formula, data.draw(traces(horizon(formula) + 1 + data.draw(st.integers(0, 2)), ties=ties))
    )


def test_the_law_above_meets_every_kind_of_claim():
    rng, met = np.random.default_rng(3), dict.fromkeys((PLACE, NEVER, HELD), 0)
    texts = ["G_[0:3](A -> F_[1:2](B))", "!((A)U_[1:3](F_[2:3](B)))", "!((A)U_[1:3](B | C))"]
    texts += ["F_[0:3](G_[1:2](A) & B)", "(!C)U_[1:4](B)", "F_[1:3](!A) & G_[0:2](!B)"]
    for formula in map(parse, texts):
        for _ in range(40):
            text = check(formula, rng.normal(size=(horizon(formula) + 1, 3)))
            for claim in met:
                met[claim] += bool(claim.search(text))
    assert min(met.values()) >= 10


def reference_misses(formula: Formula, margins: np.ndarray, t: int = 0) -> float:  # noqa: PLR0911
    """Misses by the definition, for formulas in negation normal form without constants."""

    def count(operand: Formula, step: int) -> float:
        return reference_misses(operand, margins, step)

    if is_state_formula(formula):
        return float(reference_robustness(formula, margins, ATOMS, t) < 0)
    match formula:
        case And(operands=operands):
            return sum(count(each, t) for each in operands)
        case Or(operands=operands):
            return min(count(each, t) for each in operands)
        case Always(interval=(a, b), operand=operand):
            return sum(count(operand, t + k) for k in range(a, b + 1))
        case Eventually(interval=(a, b), operand=operand):
            return min(count(operand, t + k) for k in range(a, b + 1))
        case Until(interval=(a, b), left=left, right=right):
            return min(
                count(right, t + k) + sum(count(left, t + i) for i in range(k + 1))
                for k in range(a, b + 1)
            )
        case Not(operand=Until(interval=(a, b), left=left, right=right)):
            fails, never = negation_normal_form(Not(left)), negation_normal_form(Not(right))
            return min(
                sum(count(never, t + k) for k in range(a, b + 1)),
                *(
                    count(fails, t + s) + sum(count(never, t + k) for k in range(a, s))
                    for s in range(b + 1)
                ),
            )
    raise TypeError(formula)


@settings(max_examples=200, deadline=None)
@given(FORMULAS, st.data())
def test_misses_are_those_of_the_definition(formula, data):
    normal = negation_normal_form(fold_constants(formula))
    margins = data.draw(traces(horizon(formula) + 3))
    found = Misses(Signals(margins, ATOMS))[normal]
    assert found.tolist() == [reference_misses(normal, margins, t) for t in range(len(found))]
    assert len(found) == len(margins) - horizon(normal)


@settings(max_examples=100, deadline=None)
@given(st.text("+-", min_size=7, max_size=7))
@example("+---+++")
def test_the_closest_attempt_misses_least(signs):
    misses = [signs[start : start + 4].count("-") for start in range(4)]
    text = sentence("F_[0:3](G_[0:3](A))", columns(A=signs))
    attempt = re.search(r"closest attempt \(step (\d)\)", text)
    assert (attempt is None) == (0 in misses or "+" not in signs)
    if attempt is not None:
        assert misses[int(attempt[1])] == min(misses)


def test_attempts_at_several_things_count_them_all():
    # From step 0 on, A and four steps of B are missed; from step 1 on, A alone.
    margins = columns(A="--------", B="-----+++", C="++++++++")
    text = sentence("F_[0:1](G_[0:0](A) & G_[4:6](B) & C)", margins)
    assert "A was never reached" in text
    margins = columns(A="+-------", B="-----+++", C="++++++++")
    text = sentence("F_[0:1](A & G_[4:6](B) & C)", margins)
    assert text.startswith("Violated: in the closest attempt (step 0), the robot was outside B at")


def test_a_negated_until_names_what_its_right_side_reads():
    margins = columns(A="++++++++++", B="------++--")
    found = diagnose(parse("!((A)U_[0:3](F_[5:6](B)))"), margins, ATOMS, DT)
    assert (found.step, found.atom) == (6, "B")
    assert found.sentence == (
        "Violated: A held until F_[5:6](B) held: the robot was in B at step 6 (1.2 s), 1.00 m "
        "deep, but !((A)U_[0:3](F_[5:6](B))) forbids it."
    )


@pytest.mark.parametrize(
    ("text", "margins", "event"),
    [
        # The window of B closes at step 5, that of A at step 9 or later.
        (
            "(F_[0:9](A))U_[0:5](B)",
            columns(A="-" * 16),
            "B was never reached between steps 0 and 5",
        ),
        # The left side at step 0 is lost at step 9, at step 1 already at step 2.
        (
            "(G_[0:1](!C) & F_[0:9](A))U_[0:5](B)",
            columns(B="---+" + "-" * 12, C="--+" + "-" * 13),
            "failed before B was reached: the robot was in C at step 2",
        ),
        # What fails after B was reached is not asked for.
        (
            "(F_[0:3](A | C) & G_[0:1](!C))U_[2:3](B)",
            columns(A="-" * 9, B="---+-----", C="----+----"),
            "failed: A | C never held between steps 0 and 3 ",
        ),
        # C comes at the same time as B, and before B where B came too early to count.
        ("(!C)U_[0:5](B)", columns(B="--+---", C="--+---"), "1.00 m deep, when B was reached, but"),
        ("(!C)U_[2:5](B)", columns(B="+---+-", C="--+---"), "1.00 m deep, but"),
        ("(!C)U_[0:5](B)", columns(B="---++-", C="-++++-"), "steps 1-3 (0.2-0.6 s), up to"),
    ],
)
def test_of_an_until_the_side_that_was_lost_first_is_named(text, margins, event):
    assert event in check(parse(text), margins)


def test_of_hopeless_conjuncts_the_one_lost_first_is_named():
    # At no step of [0, 3] does F_[0:9](A) or B hold; B is lost at step 3, A at step 12.
    assert "B was never reached" in sentence("F_[0:3](F_[0:9](A) & B)", columns(A="-" * 13))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("(A)U_[1:3](true)", "Violated: the robot was outside A during steps 0-1 (0-0.2 s)"),
        ("G_[0:1](A & true)", "but G_[0:1](A) requires it to be inside."),
        ("F_[0:1](false | A)", "A was never reached between steps 0 and 1"),
        (
            "!(true & B) & A & G_[0:1](false)",
            "Violated: the formula fails whatever the robot does.",
        ),
        ("true & !A", "Satisfied; the tightest margin is 1.00 m from A at step 0 (0 s)."),
    ],
)
def test_no_sentence_speaks_of_constants(text, expected):
    assert expected in check(parse(text), columns(A="----"))


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_only_a_number_that_is_read_breaks_the_verdict(number):
    formula = parse("F_[0:5](A) & (C)U_[0:1](B)")
    margins = np.ones((7, 3))
    margins[5, 1] = margins[6] = number
    assert diagnose(formula, margins, ATOMS, DT).satisfied
    margins[5, 0] = number
    found = diagnose(formula, margins, ATOMS, DT)
    assert (found.satisfied, found.robustness, found.step) == (False, -np.inf, 5)
    assert found.sentence == (
        "Violated: the simulation broke down at step 5 (1 s): its numbers are no longer finite."
    )


@settings(max_examples=150, deadline=None)
@given(FORMULAS, st.data())
def test_a_sample_that_is_not_read_changes_no_explanation(formula, data):
    margins = data.draw(traces(horizon(formula) + 3))
    broken = np.where(reference_reads(formula, ATOMS, len(margins)), margins, np.nan)
    assert diagnose(formula, broken, ATOMS, DT) == diagnose(formula, margins, ATOMS, DT)
