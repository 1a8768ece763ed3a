"""The translation to rtamt, on traces whose verdict is plain to see."""

import pytest

from tests.scenes.oracle import rtamt_robustness, to_rtamt

NAMES = ("A", "B")


@pytest.mark.parametrize(
    ("text", "a", "b", "expected"),
    [
        ("F_[0:2](A)", [-3, -2, -1, 9], [0] * 4, -1),
        ("G_[1:2](!A)", [9, -2, -1, 9], [0] * 4, 1),
        ("F_[0:1](A & G_[0:1](B))", [1, 2, 0, 0], [5, 4, 3, 0], 2),
        ("(!B)U_[0:3](A)", [-1, -1, 7, 7], [-5, -4, -3, 9], 3),
        ("(!B)U_[0:3](A)", [-1, -1, 7, 7], [-5, -4, 3, 9], -1),
        ("(!B)U_[2:3](A) & F_[0:3](B)", [9, 9, 7, 7], [-5, 4, -3, 9], -4),
    ],
)
def test_known_robustness(text, a, b, expected):
    margins = [list(pair) for pair in zip(a, b, strict=True)]
    assert rtamt_robustness(text, NAMES, margins) == expected


def test_the_left_side_of_until_is_asked_at_the_last_step_too():
    """Step 2 satisfies A but also B: rtamt's own until would not look at B there."""
    assert rtamt_robustness("(!B)U_[0:2](A)", NAMES, [[-1, -5], [-1, -4], [7, 3]]) == -1


def test_operators_are_names_without_an_interval():
    assert to_rtamt("G_[0:5](G)").replace(" ", "") == "always[0:5]((m_G>=0))"
