"""What simulation says of a map's cells, beside what the critic says."""

from typing import Any

import jax.numpy as jnp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import spearmanr

from core.attempts import tries
from core.evaluation import trace_robustness
from core.heatmap import Heatmap, heatmap
from core.rollout import roll_out
from core.truth import (
    GRID,
    Truth,
    misjudged,
    nothing_simulated,
    simulate_more,
    simulation_order,
    spearman,
)

Asked = tuple[Any, Any, Any]
BASE = np.array([20, 50, 15, 0, 0, 0, 0, 0], np.int32)


@pytest.fixture(scope="module")
def drawn(asked: Asked) -> Heatmap:
    return heatmap(*asked, BASE, (0, 1))


@pytest.fixture(scope="module")
def whole(asked: Asked, drawn: Heatmap) -> Truth:
    truth = nothing_simulated(drawn)
    while not truth.complete:
        truth = simulate_more(*asked, truth)
    return truth


def test_cells_are_those_of_the_map_from_end_to_end(drawn: Heatmap):
    truth = nothing_simulated(drawn)
    assert truth.robustness.shape == (GRID, GRID)
    assert not truth.simulated.any() and not truth.satisfied.any()
    assert (truth.columns[0], truth.columns[-1]) == (0, drawn.first.size - 1)
    assert (truth.rows[0], truth.rows[-1]) == (0, drawn.second.size - 1)
    cell = truth.rows[5], truth.columns[9]
    assert truth.heatmap.values[5, 9] == drawn.values[cell]
    assert truth.heatmap.shortfall[5, 9] == drawn.shortfall[cell]
    np.testing.assert_array_equal(truth.schedules[5, 9], drawn.schedule_at(*cell))
    assert drawn.legs is not None and truth.heatmap.legs is not None
    assert truth.heatmap.legs.needed[5, 9] == drawn.legs.needed[cell]


def test_values_are_those_of_single_rollouts(asked: Asked, drawn: Heatmap, whole: Truth):
    task, controller, state = asked
    count = tries(task)
    assert len(np.unique(whole.robustness)) > 5
    for row, column in [(0, 0), (3, 17), (23, 23)]:
        schedule = drawn.schedule_at(whole.rows[row], whole.columns[column])
        states, schedules = (jnp.tile(jnp.asarray(x), (count, 1)) for x in (state, schedule))
        margins = np.asarray(roll_out(task, controller, states, schedules).margins)
        alone = trace_robustness(task, margins)[0]
        assert whole.robustness[row, column] == pytest.approx(alone, abs=1e-5)


def test_a_step_simulates_a_batch_and_keeps_what_is_known(asked: Asked, drawn: Heatmap):
    count = tries(asked[0])
    one = simulate_more(*asked, nothing_simulated(drawn))
    two = simulate_more(*asked, one)
    assert (one.simulated.sum(), two.simulated.sum()) == (count, 2 * count)
    assert one.simulated[::4, ::4].all()
    np.testing.assert_array_equal(two.robustness[one.simulated], one.robustness[one.simulated])


def test_what_is_complete_stays(asked: Asked, whole: Truth):
    assert simulate_more(*asked, whole) is whole


def test_coarse_grids_come_first():
    order = simulation_order((24, 24))
    assert sorted(order) == list(range(576))
    for cells, stride in [(36, 4), (144, 2)]:
        rows, columns = np.unravel_index(order[:cells], (24, 24))
        assert not (rows % stride).any() and not (columns % stride).any()


@pytest.mark.parametrize("axes", [(0,), ()])
def test_fewer_axes(asked: Asked, axes):
    truth = nothing_simulated(heatmap(*asked, BASE, axes))
    assert truth.robustness.shape == (1, GRID if axes else 1)
    assert simulate_more(*asked, truth).complete


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=2))
def test_the_rank_correlation_is_scipys_with_ties(pairs):
    one, other = np.array(pairs, float).T
    if np.ptp(one) == 0 or np.ptp(other) == 0:
        assert np.isnan(spearman(one, other))
        return
    expected = spearmanr(one, other).statistic  # pyright: ignore[reportAttributeAccessIssue]
    assert spearman(one, other) == pytest.approx(expected, abs=1e-12)


def test_the_rank_correlation_of_what_is_finite_by_hand():
    """Ranks 1, 2.5, 2.5, 4 and 1, 3, 2, 4: 4.5 / sqrt(4.5 * 5)."""
    one = np.array([1.0, 7, 7, 9, 100, -100, np.nan])
    other = np.array([-5.0, 3, 2, 8, np.nan, -np.inf, 4])
    assert spearman(one, other) == pytest.approx(4.5 / np.sqrt(4.5 * 5))
    assert np.isnan(spearman(one[:1], other[:1]))


def test_the_critics_best_are_compared_with_those_that_satisfy():
    values = np.array([[9.0, 8, 7, 6, 5], [np.nan, 99, 4, 3, 2]])
    robustness = np.array([[1.0, -1, 0, 0.5, np.nan], [-1, -1, -2, -np.inf, -1]])
    five, two = np.arange(5), np.arange(2)
    drawn = Heatmap((0, 1), five, two, values, np.zeros((2, 5)), BASE)
    truth = Truth(drawn, two, five, np.zeros((2, 5, 8)), robustness)
    considered = np.ones((2, 5), bool)
    considered[1, 1] = False
    # Three satisfy, two of which are among the three best; the unknown and the left out are not.
    assert np.argwhere(misjudged(truth, considered)).tolist() == [[0, 1], [0, 3]]
    assert not misjudged(truth, considered & (robustness < 0)).any()
