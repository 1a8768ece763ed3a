"""The map over a real task with untrained networks: which schedules does it score?"""

from typing import Any

import numpy as np
import pytest

from core.heatmap import BATCH, COARSE, RESOLUTION, best_schedule, heatmap, random_schedules, score

Asked = tuple[Any, Any, Any]
BASE = np.array([20, 50, 15, 0, 0, 0, 0, 0], np.int32)


def test_cells_have_their_schedules_scores(asked: Asked):
    drawn = heatmap(*asked, BASE, (0, 1))
    assert drawn.values.shape == (41, 91)
    assert drawn.first.size <= RESOLUTION
    schedule = drawn.schedule_at(7, 30)
    assert schedule[:3].tolist() == [30, 47, 15]
    alone = score(*asked, schedule[None])
    assert drawn.values[7, 30] == pytest.approx(float(alone.values[0]), abs=1e-4)
    assert drawn.legs is not None
    assert drawn.legs.needed[7, 30] == pytest.approx(float(alone.legs.needed[0]))


def test_more_schedules_than_a_batch_are_scored_in_pieces(asked: Asked):
    schedules = random_schedules(asked[0], BATCH + 5, {})
    together = score(*asked, schedules)
    assert together.values.shape == (BATCH + 5,)
    last = score(*asked, schedules[BATCH:])
    np.testing.assert_allclose(together.values[BATCH:], last.values, atol=1e-4)


def test_the_best_over_the_rest_is_at_least_every_alternative(asked: Asked):
    task = asked[0]
    rest = random_schedules(task, 4, {})
    best = heatmap(*asked, BASE, (0, 1), rest)
    assert best.first.size == COARSE
    row, column = 11, 30
    one = best.schedule_at(row, column)
    assert (one[0], one[1]) == (best.first[column], best.second[row])
    assert one[2] in rest[:, 2]
    tried = np.tile(one, (4, 1))
    tried[:, 2] = rest[:, 2]
    scores = score(*asked, tried)
    assert float(best.values[row, column]) == pytest.approx(float(scores.values.max()), abs=1e-3)


def test_fixed_entries_stay(asked: Asked):
    best = best_schedule(*asked, {1: 60, 2: 12})
    assert best[1:3].tolist() == [60, 12]
    assert 0 <= best[0] <= 90


@pytest.mark.parametrize(("axes", "shape"), [((0,), (1, 91)), ((), (1, 1))])
def test_fewer_axes(asked: Asked, axes, shape):
    assert heatmap(*asked, BASE, axes).values.shape == shape
