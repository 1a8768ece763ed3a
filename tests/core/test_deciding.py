"""Which margin decided a robustness."""

import numpy as np

from core.deciding import Deciding, deciding_margin

MARGINS = np.array([[0.5, 2.0], [-0.25, 1.0], [0.75, 0.25]])


def test_the_deciding_margin_is_the_first_that_is_the_robustness():
    assert deciding_margin(-0.25, MARGINS) == Deciding(1, 0, 1)
    assert deciding_margin(2.0, MARGINS) == Deciding(0, 1, 1)


def test_of_a_negated_atom_the_robustness_is_the_negative():
    assert deciding_margin(-1.0, MARGINS) == Deciding(1, 1, -1)
    assert deciding_margin(-0.5, MARGINS) == Deciding(0, 0, -1)


def test_a_bound_between_the_steps_has_none():
    assert deciding_margin(0.1, MARGINS) is None
