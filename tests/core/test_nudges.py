"""Nudges: their size, how smooth they are, and where they are focused."""

import numpy as np

from core.nudges import AFTER, BEFORE, PERSISTENCE, SCALE, SIZES, drawn_nudges


def test_nudges_are_smooth_and_of_three_sizes():
    nudges = drawn_nudges(np.random.default_rng(0), 4000, 2, [None] * 30)
    assert nudges.shape == (4000, 30, 2) and nudges.dtype == np.float32
    deviation = nudges.std((0, 2))
    nearest = SCALE * np.array(SIZES)[np.abs(deviation[:, None] / SCALE - SIZES).argmin(1)]
    np.testing.assert_allclose(deviation, nearest, rtol=0.15)
    assert len(np.unique(nearest)) == len(SIZES)
    scaled = nudges / deviation[:, None]
    correlation = (scaled[1:] * scaled[:-1]).mean()
    assert abs(correlation - PERSISTENCE) < 0.03


def test_focused_nudges_are_around_a_step():
    nudges = drawn_nudges(np.random.default_rng(1), 100, 2, [50] * 40 + [0, 99])
    steps = np.flatnonzero(nudges[:, :40].any((1, 2)))
    assert 50 - BEFORE <= steps.min() < 40 and 50 < steps.max() < 50 + AFTER
    assert nudges[0, 40].any() and nudges[99, 41].any()


def test_nudges_of_the_same_seed_are_the_same():
    first, second = (
        drawn_nudges(np.random.default_rng(3), 20, 1, [None, 5, None, 7]) for _ in range(2)
    )
    np.testing.assert_array_equal(first, second)
