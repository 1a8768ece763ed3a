"""Untils whose sides exclude each other are said to, and the rewrite is the strict until."""

import numpy as np
import pytest

from core.decompose import advice, strict_until
from core.stl import Until, parse, to_text
from tests.core.stl.reference import reference_satisfied

NAMES = ("A", "B")


@pytest.mark.parametrize(
    ("text", "better"),
    [
        ("(!A) U_[0:30] A", "F_[0:30](A)"),
        ("(!A & !B) U_[0:30] A", "A | (!A & !B)U_[0:29](F_[1:1](A))"),
        ("(!A) U_[2:30] A", "(!A)U_[1:29](F_[1:1](A))"),
        ("(!A) U_[0:0] A", "A"),
        ("A U_[0:9] (!A & F_[0:5](B))", "!A & F_[0:5](B) | (A)U_[0:8](F_[1:1](!A & F_[0:5](B)))"),
        ("(!A) U_[0:9] (A & G_[0:5](!B))", None),
        ("(!B) U_[0:9] (A & G_[0:5](B))", None),
        ("F_[0:9](B & (!A) U_[0:9] (A U_[0:9] B))", None),
        ("!(!((!A) U_[0:9] A))", "F_[0:9](A)"),
        ("G_[0:9](B -> (!A) U_[0:9] A)", "F_[0:9](A)"),
        ("(A -> !B) U_[0:9] (A & B)", None),
    ],
)
def test_exclusive_untils_are_named(text, better):
    (sentence,) = advice(parse(text))
    assert "boundary only" in sentence
    if better is not None:
        assert f"`{better}`" in sentence


@pytest.mark.parametrize(
    "text",
    [
        "(!B) U_[0:9] A",
        "(!A | B) U_[0:9] A",
        "(!A) U_[0:9] (F_[1:8](A))",
        "!((!A) U_[0:9] A)",
        "((!A) U_[0:9] A) -> B",
        "true U_[0:9] A",
        "(!A) U_[0:9] (A | B)",
        "F_[0:9](A) & G_[0:9](!A)",
    ],
)
def test_others_are_not(text):
    assert advice(parse(text)) == ()


@pytest.mark.parametrize("interval", ["[0:0]", "[0:3]", "[1:3]", "[2:2]"])
@pytest.mark.parametrize("sides", [("!A", "A"), ("!A & !B", "A"), ("!B", "A")])
def test_the_rewrite_is_the_strict_until(interval, sides):
    left, right = map(parse, sides)
    until = parse(f"({sides[0]}) U_{interval} ({sides[1]})")
    assert isinstance(until, Until)
    first, last = until.interval
    better = parse(to_text(strict_until(until)))
    verdicts = set()
    for trace in np.random.default_rng(0).choice([-1.0, 1.0], (300, 5, 2)):
        expected = any(
            reference_satisfied(right, trace, NAMES, k)
            and all(reference_satisfied(left, trace, NAMES, j) for j in range(k))
            for k in range(first, last + 1)
        )
        assert reference_satisfied(better, trace, NAMES) == expected
        verdicts.add(expected)
    assert verdicts == {True, False}
