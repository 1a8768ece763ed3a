"""Shared by the heatmap on the page and its picture: marks and the colour range."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.heatmap import Heatmap

TOLERANCE = 1.0
"""Shortfall up to which a schedule still counts as feasible [steps]."""


@dataclass(frozen=True)
class Mark:
    """A schedule marked on the heatmap."""

    schedule: Sequence[int]
    color: str
    label: str


def color_range(heatmap: Heatmap) -> tuple[float, float]:
    """Values at the ends of the colour bar: those of the schedules that leave time to travel."""
    sound = heatmap.values[(heatmap.shortfall <= TOLERANCE) & np.isfinite(heatmap.values)]
    if sound.size == 0:
        sound = heatmap.values[np.isfinite(heatmap.values)]
    if sound.size == 0:
        return 0.0, 1.0
    low, high = float(sound.min()), float(sound.max())
    return (low, high) if high - low > 1e-6 else (low - 0.5, high + 0.5)
