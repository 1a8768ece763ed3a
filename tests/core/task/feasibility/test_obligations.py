"""The law of obligations: every trace that satisfies a formula meets them, by brute force."""

from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from core.stl import Atom, Formula, horizon, parse, robustness, robustness_signal
from core.task.feasibility.obligations import Instant, Obligations, obligations_of
from tests.strategies import ATOMS, formulas, traces

MOST = 3000
"""Combinations of steps and alternatives that are tried."""

START = Atom("A")


def combinations(found: Obligations, last: int):
    """All values of the unknown steps, and of the choices; none if they are too many."""
    steps: list[list[int]] = [[0]]
    for node in found.nodes:
        steps = [
            [*known, known[node.after.node] + node.after.offset + ahead]
            for known in steps
            for ahead in range(node.low, node.high + 1)
            if known[node.after.node] + node.after.offset + ahead <= last
        ]
        if len(steps) > MOST:
            return None
    chosen = list(product(*(range(len(choice.alternatives)) for choice in found.choices)))
    return product(steps, chosen) if len(steps) * len(chosen) <= MOST else None


def met(found: Obligations, margins: np.ndarray) -> bool | None:
    """Whether some values meet all holds but the start's; None if they are too many."""
    held = [
        np.asarray(robustness_signal(hold.predicate, margins, ATOMS)) >= 0 for hold in found.holds
    ]

    def at(instant: Instant, steps: list[int]) -> int:
        return steps[instant.node] + instant.offset

    tried = combinations(found, len(margins) - 1)
    if tried is None:
        return None
    for steps, chosen in tried:
        if all(
            held[i][at(hold.start, steps) : at(hold.end, steps) + 1].all()
            for i, hold in enumerate(found.holds)
            if i > 0 and all(chosen[number] == value for number, value in hold.scope)
        ):
            return True
    return False


@settings(max_examples=150, deadline=None)
@given(formulas(3, max_bound=3), st.data())
def test_satisfying_traces_meet_the_obligations(formula: Formula, data):
    margins = data.draw(traces(horizon(formula) + 1))
    assume(robustness(formula, margins, ATOMS) >= 0)
    answer = met(obligations_of(formula, START), margins)
    assume(answer is not None)
    assert answer


@pytest.mark.parametrize(
    ("text", "rows"),
    [
        ("F_[0:1](A) & G_[0:2](!B)", [(-1, -1), (-1, -1), (1, -1)]),
        ("(!B) U_[1:2] A", [(-1, -1), (1, 1), (-1, -1)]),
        ("G_[0:1](F_[0:1](A))", [(1, -1), (-1, -1), (-1, -1)]),
        ("F_[0:1](A) | G_[0:2](B)", [(-1, 1), (-1, -1), (-1, 1)]),
    ],
)
def test_these_traces_do_not(text, rows):
    margins = np.array([(*row, 0.0) for row in rows], float)
    assert met(obligations_of(parse(text, names=ATOMS), START), margins) is False


def test_the_start_comes_first():
    found = obligations_of(parse("F_[0:9](B)", names=ATOMS), START)
    assert [hold.predicate for hold in found.holds] == [START, Atom("B")]
    assert found.holds[0].start == found.holds[0].end == Instant()


def test_huge_formulas_stay_small():
    text = "G_[0:9](F_[0:9](" * 12 + "A" + "))" * 12
    found = obligations_of(parse(text, names=ATOMS), START)
    assert len(found.holds) <= 48 and len(found.nodes) <= 24
