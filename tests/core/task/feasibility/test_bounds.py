"""Bounds on steps, against all solutions of small problems."""

from itertools import product

import numpy as np
import pytest

from core.stl import Atom, parse
from core.task.feasibility.bounds import Bounds, Constraint, apart
from core.task.feasibility.obligations import Instant, obligations_of

FOUND = obligations_of(
    parse("F_[1:4](A & F_[0:3](B)) & F_[2:6](C)", names=("A", "B", "C")), Atom("A")
)


def solutions(constraints):
    """Steps (0, t1, t2, t3) that keep the formula's intervals and the constraints."""
    found = []
    for t1, ahead, t3 in product(range(1, 5), range(4), range(2, 7)):
        steps = (0, t1, t1 + ahead, t3)
        if all(steps[b] - steps[a] <= most for a, b, most in constraints):
            found.append(steps)
    return found


@pytest.mark.parametrize("seed", range(30))
def test_they_are_those_of_all_solutions(seed):
    random = np.random.default_rng(seed)
    bounds, kept = Bounds.of(FOUND), []
    for _ in range(4):
        a, b = (int(k) for k in random.choice(4, 2, replace=False))
        constraint = Constraint(a, b, int(random.integers(-3, 4)))
        allowed = bool(solutions([*kept, constraint]))
        assert bounds.allows(constraint) == allowed
        if allowed:
            kept.append(constraint)
            bounds = bounds.having(constraint)
    steps = np.array(solutions(kept))
    for node in range(4):
        assert bounds.first(Instant(node)) == steps[:, node].min()
        assert bounds.last(Instant(node, 2)) == steps[:, node].max() + 2
    for a, b in product(range(4), repeat=2):
        most = int((steps[:, b] - steps[:, a]).max())
        assert bounds.between(Instant(a), Instant(b)) == most
        assert bounds.implies(Constraint(a, b, most))
        assert not bounds.implies(Constraint(a, b, most - 1))


def test_apart_counts_the_offsets():
    assert apart(Instant(1, 3), Instant(2, 1), 4) == Constraint(2, 1, -6)
