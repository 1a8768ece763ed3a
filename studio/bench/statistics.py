"""Means over seeds with Student-t intervals. The seed is the statistical unit.

What one seed came to is the mean over its tasks; these means, and not the single runs, are the
sample. With one seed there is no interval, which is shown as such.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

CONFIDENCE = 0.95


class Estimate(NamedTuple):
    """A mean over seeds."""

    mean: float
    half_width: float
    """Of the interval; NaN with one seed."""
    seeds: int
    runs: int

    @property
    def text(self) -> str:
        """`0.973 +- 0.012 (3 seeds, 30 runs)`."""
        width = "" if np.isnan(self.half_width) else f" ± {self.half_width:.3f}"
        seeds = "1 seed" if self.seeds == 1 else f"{self.seeds} seeds"
        runs = "1 run" if self.runs == 1 else f"{self.runs} runs"
        return f"{self.mean:.3f}{width} ({seeds}, {runs})"


def over_seeds(rows: Iterable[Mapping[str, Any]], value: str) -> Estimate:
    """The mean of a column over the seeds of some runs, of at least one."""
    by_seed: dict[int, list[float]] = defaultdict(list)
    for row in rows:
        by_seed[row["seed"]].append(row[value])
    means = [float(np.mean(values)) for values in by_seed.values()]
    mean, half_width = interval(means)
    return Estimate(mean, half_width, len(means), sum(map(len, by_seed.values())))


def interval(sample: Sequence[float]) -> tuple[float, float]:
    """Mean of a sample and half the width of its Student-t interval, NaN for a sample of one."""
    count, mean = len(sample), float(np.mean(sample))
    if count < 2:
        return mean, float("nan")
    error = float(np.std(sample, ddof=1)) / count**0.5
    return mean, error * float(stats.t.ppf((1 + CONFIDENCE) / 2, count - 1))


def curve_at(
    curve: Sequence[Mapping[str, Any]], seconds: np.ndarray, clock: str = "seconds"
) -> np.ndarray:
    """Success rate of a training's last evaluation at some times [K]; 0 before the first.

    `clock` is the column of the evaluations that the times refer to.
    """
    times = np.array([point[clock] for point in curve])
    rates = np.array([0.0, *(point["success_rate"] for point in curve)])
    return rates[np.searchsorted(times, seconds, side="right")]
