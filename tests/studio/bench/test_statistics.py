"""Intervals over seeds, against textbook values."""

import math

import numpy as np
import pytest

from studio.bench.statistics import curve_at, interval, over_seeds


def test_the_interval_of_a_sample():
    mean, half = interval([1.0, 2.0, 3.0])
    assert mean == 2
    assert half == pytest.approx(4.30265 / math.sqrt(3), rel=1e-5)  # t of two degrees of freedom


def test_one_seed_has_no_interval():
    mean, half = interval([0.7])
    assert mean == 0.7 and math.isnan(half)


def test_the_interval_covers_the_mean_as_often_as_it_says():
    random = np.random.default_rng(0)
    covered = 0
    for sample in random.normal(1.0, 2.0, (2000, 4)):
        mean, half = interval(sample.tolist())
        covered += abs(mean - 1.0) <= half
    assert covered / 2000 == pytest.approx(0.95, abs=0.02)


def test_the_seed_is_the_unit():
    rows = [{"seed": 1, "x": 1.0}, {"seed": 1, "x": 0.0}, {"seed": 2, "x": 0.7}]
    estimate = over_seeds(rows, "x")
    assert (estimate.mean, estimate.seeds, estimate.runs) == (pytest.approx(0.6), 2, 3)
    assert estimate.half_width == pytest.approx(interval([0.5, 0.7])[1])
    assert estimate.text.startswith("0.600 ± ") and estimate.text.endswith("(2 seeds, 3 runs)")


def test_a_curve_is_a_step_function():
    curve = [{"seconds": 1.0, "success_rate": 0.5}, {"seconds": 3.0, "success_rate": 0.9}]
    assert curve_at(curve, np.array([0.0, 1.0, 2.9, 3.0, 9.0])).tolist() == [0, 0.5, 0.5, 0.9, 0.9]
