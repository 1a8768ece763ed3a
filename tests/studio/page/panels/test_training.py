import numpy as np

from studio.page.panels.training import MOST_POINTS, curve_data
from studio.page.trainer import Point


def curve(count):
    return tuple(Point(epoch, epoch / 10_000, float("nan")) for epoch in range(1, count + 1))


def test_short_curves_are_drawn_in_full():
    epochs, batch, evaluated = curve_data(curve(3))
    assert epochs.tolist() == [1, 2, 3]
    np.testing.assert_allclose(batch, [0.01, 0.02, 0.03])
    assert np.isnan(evaluated).all()


def test_long_curves_are_thinned_but_keep_their_ends():
    epochs, *_ = curve_data(curve(4321))
    assert len(epochs) <= MOST_POINTS
    assert (epochs[0], epochs[-1]) == (1, 4321)
