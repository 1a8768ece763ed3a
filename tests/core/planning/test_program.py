"""Programs with known solutions."""

import math

import pytest

from core.planning.program import INFINITY, Program


def knapsack() -> tuple[Program, int]:
    """Values 5, 4, 3 of sizes 4, 3, 2, of which 6 fit: 8 at most."""
    program = Program()
    items = [program.column(0, 1, integer=True) for _ in range(3)]
    worth = program.column(0, INFINITY)
    program.row(dict(zip(items, (4.0, 3.0, 2.0), strict=True)), -INFINITY, 6)
    program.row({worth: 1.0} | dict(zip(items, (-5.0, -4.0, -3.0), strict=True)), 0, 0)
    return program, worth


def test_an_integer_program():
    program, worth = knapsack()
    solution = program.maximise(worth, 10.0)
    assert solution.values is not None and solution.values[worth] == pytest.approx(8)
    assert solution.bound == pytest.approx(8)


def test_a_linear_program():
    program = Program()
    x, y = program.column(0, 3), program.column(-1, INFINITY)
    program.row({x: 1.0, y: 1.0}, -INFINITY, 5)
    assert program.maximise(y, 10.0).bound == pytest.approx(5)


def test_no_solution():
    program, worth = knapsack()
    program.row({worth: 1.0}, 9, INFINITY)
    solution = program.maximise(worth, 10.0)
    assert solution.values is None and solution.bound == -math.inf


def test_without_a_bound_nothing_is_claimed():
    program = Program()
    x = program.column(0, INFINITY)
    solution = program.maximise(x, 10.0)
    assert solution.values is None and solution.bound == math.inf


def test_nothing_is_printed(capfd):
    program, worth = knapsack()
    program.maximise(worth, 10.0)
    assert capfd.readouterr().out == ""
