"""The strict reading against a plain evaluation on a finer trace."""

import numpy as np
import pytest

from core.between import Between, between, between_margins, between_sentence, strict_robustness
from core.evaluation import trace_robustness
from core.stl import (
    Always,
    And,
    Atom,
    Eventually,
    Formula,
    Not,
    Or,
    Until,
    is_state_formula,
    parse,
    robustness_signal,
)
from tests.core.toy import CENTERS, disc_margins, toy_task

FORMULAS = [
    "G_[0:14](!B)",
    "F_[0:6](A) & G_[0:14](!B & !D)",
    "F_[2:6](G_[0:4](A))",
    "(!A) U_[0:9] B",
    "(!D) U_[3:9] B & G_[1:5](G_[0:5](!C))",
    "F_[0:8](A) | G_[0:9](!A)",
    "G_[0:9](A | B | C | D)",
    "G_[2:5](F_[3:3](!B))",
    "G_[4:4](!B) & F_[0:9](C)",
]
NAMES, FINE, TRACES, STEPS = tuple(CENTERS), 60, 24, 16


def traces(seed: int) -> np.ndarray:
    """Random walks [R, T + 1, 2] among the discs, in steps as long as the discs are wide."""
    random = np.random.default_rng(seed)
    moves = random.normal(0, 0.7, (TRACES, STEPS, 2))
    start = random.uniform(-2, 2, (TRACES, 1, 2))
    return np.concatenate([start, start + np.cumsum(moves, 1)], 1)


def plainly(formula: Formula, step: int, at: np.ndarray) -> float:
    """The strict reading on margins [T * FINE + 1, A] of a fine trace."""
    match formula:
        case Always(interval=(a, b), operand=Always(interval=(c, d), operand=inner)):
            return plainly(Always((a + c, b + d), inner), step, at)  # pyright: ignore
        case Always(interval=(a, b), operand=Eventually(interval=(c, d), operand=inner)) if c == d:
            return plainly(Always((a + c, b + d), inner), step, at)  # pyright: ignore
        case Always(interval=(a, b), operand=inner) if is_state_formula(inner):
            return float(state(inner, at)[(step + a) * FINE : (step + b) * FINE + 1].min())
        case Eventually(interval=(a, b), operand=inner):
            return max(plainly(inner, step + t, at) for t in range(a, b + 1))
        case Until(interval=(a, b), left=left, right=right):
            held = state(left, at)
            return max(
                min(
                    plainly(right, step + t, at),
                    float(held[step * FINE : (step + t) * FINE + 1].min()),
                )
                for t in range(a, b + 1)
            )
        case And(operands=operands):
            return min(plainly(each, step, at) for each in operands)
        case Or(operands=operands):
            return max(plainly(each, step, at) for each in operands)
    return float(state(formula, at)[step * FINE])


def state(formula: Formula, at: np.ndarray) -> np.ndarray:
    """A state formula along the fine trace."""
    assert isinstance(formula, Atom | Not | And | Or)
    return np.asarray(robustness_signal(formula, at, NAMES))


def refined(trace: np.ndarray) -> np.ndarray:
    """Margins [T * FINE + 1, A] along a trace [T + 1, 2]."""
    times = np.linspace(0, len(trace) - 1, (len(trace) - 1) * FINE + 1)
    steps = np.arange(len(trace))
    return disc_margins(np.stack([np.interp(times, steps, axis) for axis in trace.T], -1))


@pytest.mark.parametrize("text", FORMULAS)
def test_the_strict_reading_is_what_a_finer_trace_says(text):
    """Eighths of a step of 1 m or so miss at most a few centimetres, and never a sign."""
    task, formula, walks = toy_task(text), parse(text, names=CENTERS), traces(3)
    expected = np.array([plainly(formula, 0, refined(walk)) for walk in walks])
    found = strict_robustness(task, walks)
    np.testing.assert_allclose(found, expected, atol=0.12)
    clear = np.abs(expected) > 0.01
    np.testing.assert_array_equal(found[clear] >= 0, expected[clear] >= 0)


@pytest.mark.parametrize("text", FORMULAS)
def test_what_is_strictly_satisfied_is_satisfied(text):
    task, walks = toy_task(text), traces(5)
    margins = np.moveaxis(disc_margins(walks), 0, 1)
    assert (strict_robustness(task, walks) <= trace_robustness(task, margins) + 1e-4).all()


def jump(depth: float) -> np.ndarray:
    """From below the disc B, whose radius is 0.6 m, to above it, past its middle by 0.6 - depth."""
    side = 0.6 - depth
    rows = [(side, 0.2)] * 8 + [(side, 2.8)] * 9
    return np.array(rows)


def test_where_and_by_how_much_an_obstacle_is_cut():
    task = toy_task("G_[0:14](!B) & F_[0:9](A)")
    found = between(task, jump(0.1))
    assert (found.step, found.holds) == (7, False)
    assert found.margin == pytest.approx(-0.1, abs=1e-3)
    np.testing.assert_allclose(found.position, (0.5, 1.5), atol=1e-2)
    assert between_sentence(found) == (
        "Satisfied at every step; between steps 7 and 8 it cuts B by 0.10 m at (0.5, 1.5)"
    )


def test_what_holds_tells_its_least_margin():
    found = between(toy_task("G_[0:14](!B)"), jump(-0.26))
    assert found.holds and found.margin == pytest.approx(0.26, abs=1e-3)
    assert between_sentence(found) == (
        "It holds between the steps, too, by 0.26 m at least: !B between steps 7 and 8 at "
        "(0.9, 1.5)"
    )


def test_windows_say_when():
    """The jump is at steps 7 to 8: a window that contains one of them only asks for nothing."""
    for window, cut in (("0:7", False), ("8:14", False), ("7:8", True), ("0:14", True)):
        task = toy_task(f"G_[{window}](!B)")
        assert (between_margins(task, jump(0.1)[None])[0] < 0) == cut
        assert (strict_robustness(task, jump(0.1)[None])[0] < 0) == cut


def test_goals_are_out_of_account():
    """A is missed; what it is missed by is no margin between the steps."""
    found = between(toy_task("G_[0:14](!B) & F_[0:9](A & C)"), jump(-0.26))
    assert found.holds and found.margin == pytest.approx(0.26, abs=1e-3)
    assert between(toy_task("F_[0:9](A)"), jump(0.1)) == Between(np.inf)
    assert between_sentence(Between(np.inf)) == ""


def test_no_traces_have_no_margins():
    task, none = toy_task("G_[0:14](!B)"), jump(0.1)[None][:0]
    assert between_margins(task, none).shape == strict_robustness(task, none).shape == (0,)
