"""Short formulas that stand for large structures are refused before anything large is built."""

import time

import pytest

from core.errors import UserError
from tests.core.toy import toy_task


def conjunction(count: int, clause: str) -> str:
    return f"F_[0:9]({' & '.join([clause] * count)})"


@pytest.mark.parametrize(
    ("formula", "message"),
    [
        (conjunction(3, "(A | B)"), None),
        (conjunction(5, "(A | B)"), "needs 32 alternatives; at most 16 alternatives of 16 regions"),
        (conjunction(12, "(A | B | C)"), "needs 531,441 alternatives"),
        (conjunction(60, "(A | B)"), r"needs more than 10\^18 alternatives"),
        (f"F_[0:9](!({' | '.join(['A & B'] * 60)}))", r"more than 10\^18 alternatives"),
        (f"F_[0:9]({' & '.join('(A -> B)' for _ in range(30))})", "1,073,741,824 alternatives"),
        ("G_[0:1000000](F_[0:1](A))", "needs 500,001 variables or more; at most 100"),
        ("G_[0:1999](F_[0:9](G_[0:0](F_[1:2](A & B))))", "needs 182 variables or more"),
        ("G_[0:1000000](A -> F_[0:2](B))", "needs 1,000,002 steps, but at most 10,000"),
        ("G_[0:1000000](F_[0:9](A) | G_[0:1](B))", "needs 100,002 variables or more"),
        ("G_[0:1000000]((!A) U_[0:9] B)", "needs 100,001 variables or more"),
        (f"{'G_[0:3](F_[0:1](A) | F_[0:2](' * 9}B{'))' * 9}", "variables or more"),
        (f"G_[0:9]({'|'.join(['(F_[0:1](A)&F_[0:2](B))'] * 20)})", "variables|tasks"),
        (f"G_[0:9](!({'&'.join(['(A->F_[0:1](B))'] * 20)}))", "variables|tasks"),
        (f"{'G_[0:9](F_[0:1](' * 9}A{'))' * 9}", "variables or more"),
        (f"G_[0:190](F_[0:1]({'&'.join(['(A|B)'] * 60)}))", "more than 10,000 names and operators"),
        (f"G_[0:98](F_[0:1]({' & '.join(['G_[0:1](A)'] * 30)}))", "more than 1,000 tasks"),
        ("F_[0:1000000](A)", "needs 1,000,000 steps, but at most 10,000"),
        ("F_[0:9000](F_[0:9000](A))", "needs 18,000 steps, but at most 10,000"),
    ],
)
def test_a_size_is_known_before_it_is_built(formula, message):
    assert len(formula) <= 700
    began = time.process_time()
    if message is None:
        toy_task(formula)
    else:
        with pytest.raises(UserError, match=message):
            toy_task(formula)
    assert time.process_time() - began < 0.5


def test_a_long_window_is_allowed():
    assert toy_task("F_[0:5000](A)").horizon == 5000
