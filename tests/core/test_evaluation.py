"""Verdicts of simulated traces."""

import numpy as np
import pytest

from core.evaluation import trace_robustness
from core.stl import horizon, robustness
from tests.core.toy import toy_task


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_a_trace_fails_by_a_number_that_the_formula_reads_and_by_no_other(number):
    task = toy_task("F_[0:9](A) & (!D)U_[0:4](B)")
    names = task.grounding.atoms
    margins = np.random.default_rng(2).normal(size=(17, 3, len(names)))
    expected = robustness(task.formula, np.moveaxis(margins, 0, 1), names)
    margins[5:, 1, names.index("B")] = number
    margins[horizon(task.formula) + 1 :, 1] = number
    margins[4, 2, names.index("B")] = number
    found = trace_robustness(task, margins)
    np.testing.assert_array_equal(found, [expected[0], expected[1], -np.inf])
