"""What simulation says of the schedules that a heatmap scores (the paper's App. A.6).

At most 24 x 24 of the heatmap's cells are carried out, a coarse grid of them first, and the exact
robustness of each trace is compared with the critic's value: by rank, since a value is no
robustness, and by verdict.

Dimensions: h x w simulated cells, V variables, K rollouts at a time.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.attempts import tries
from core.controller import Controller
from core.evaluation import rollout_robustness
from core.heatmap import Heatmap
from core.rollout import roll_out
from core.task.protocols import Array
from core.task.task import Task

GRID = 24
"""Most cells along an axis; they are spread evenly over the heatmap's, ends included."""

STRIDES = (4, 2, 1)
"""Every fourth cell along each axis comes first, then every second, then the rest."""


class Truth(NamedTuple):
    """Robustness of the schedules of some of a heatmap's cells, as far as they are simulated."""

    heatmap: Heatmap  # of these cells alone
    rows: np.ndarray  # [h] of the whole heatmap that they are taken from
    columns: np.ndarray  # [w]
    schedules: np.ndarray  # [h, w, V]
    robustness: np.ndarray  # [h, w] [m]; NaN: not simulated yet, -inf: the simulation broke down

    @property
    def simulated(self) -> np.ndarray:
        """Whether a cell was simulated [h, w]."""
        return ~np.isnan(self.robustness)

    @property
    def satisfied(self) -> np.ndarray:
        """Whether a cell was simulated and its trace satisfies the formula [h, w]."""
        return self.robustness >= 0

    @property
    def complete(self) -> bool:
        """Whether all cells were simulated."""
        return bool(self.simulated.all())

    @property
    def correlation(self) -> float:
        """Spearman's rank correlation of value and robustness where both are finite, or NaN."""
        return spearman(self.heatmap.values, self.robustness)


def nothing_simulated(heatmap: Heatmap) -> Truth:
    """The cells that are to be simulated."""
    rows, columns = (_spread(size) for size in heatmap.values.shape)
    cells = np.ix_(rows, columns)
    schedules = np.array(
        [[heatmap.schedule_at(row, column) for column in columns] for row in rows], np.int32
    )
    chosen = heatmap._replace(
        first=heatmap.first[columns],
        second=heatmap.second[rows],
        values=heatmap.values[cells],
        shortfall=heatmap.shortfall[cells],
        schedules=schedules,
        legs=jax.tree.map(lambda leaf: np.asarray(leaf)[cells], heatmap.legs),
    )
    return Truth(chosen, rows, columns, schedules, np.full(chosen.values.shape, np.nan))


def simulate_more(task: Task, controller: Controller, state: Array, truth: Truth) -> Truth:
    """Carry out the next K cells, in the program that answers use, from a state [n]."""
    count = tries(task)
    order = simulation_order(truth.robustness.shape)
    ahead = order[~truth.simulated.ravel()[order]][:count]
    if ahead.size == 0:
        return truth
    schedules = truth.schedules.reshape(-1, truth.schedules.shape[-1])
    batch = jnp.asarray(schedules[np.resize(ahead, count)])  # filled up by repeats
    states = jnp.broadcast_to(state, (count, *state.shape))
    rollout = roll_out(task, controller, states, batch)
    known = truth.robustness.copy()
    known.ravel()[ahead] = rollout_robustness(task, rollout)[: ahead.size]
    return truth._replace(robustness=known)


def simulation_order(shape: tuple[int, ...]) -> np.ndarray:
    """Flat indices [h * w] of cells, those of the coarse grids first."""
    row, column = np.indices(shape)
    level = np.full(shape, len(STRIDES))
    for index in reversed(range(len(STRIDES))):
        stride = STRIDES[index]
        level[(row % stride == 0) & (column % stride == 0)] = index
    return np.argsort(level.ravel(), kind="stable")


def misjudged(truth: Truth, considered: np.ndarray) -> np.ndarray:
    """Cells [h, w] on whose verdict the critic's ranking is wrong.

    Where n of the considered cells satisfy the formula, the critic's n best should be these.

    Args:
        truth: as far as it is known.
        considered: cells [h, w] that are compared.
    """
    cells = np.flatnonzero(considered & truth.simulated)
    satisfied = truth.satisfied.ravel()[cells]
    values = np.nan_to_num(truth.heatmap.values.ravel()[cells], nan=-np.inf)
    liked = np.zeros(cells.size, bool)
    liked[np.argsort(-values, kind="stable")[: satisfied.sum()]] = True
    wrong = np.zeros(truth.robustness.shape, bool)
    wrong.ravel()[cells] = liked != satisfied
    return wrong


def spearman(one: np.ndarray, other: np.ndarray) -> float:
    """Spearman's rank correlation of the entries that are finite in both arrays.

    NaN where fewer than two are, or all of one array are equal.
    """
    finite = np.isfinite(one) & np.isfinite(other)
    first, second = ranks(np.asarray(one)[finite]), ranks(np.asarray(other)[finite])
    if first.size < 2 or np.ptp(first) == 0 or np.ptp(second) == 0:
        return float("nan")
    return float(np.corrcoef(first, second)[0, 1])


def ranks(values: np.ndarray) -> np.ndarray:
    """Ranks [N] of N values; equal ones share the mean of theirs."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(counts) - (counts - 1) / 2)[place]


def _spread(size: int) -> np.ndarray:
    return np.unique(np.linspace(0, size - 1, min(size, GRID)).round().astype(int))
