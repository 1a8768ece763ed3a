"""The report's figures."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt

from studio.bench.statistics import Estimate, curve_at, interval

PUBLISHED_COLOR, OWN_COLOR = "#c9ced6", "#3b6fb6"
DPI = 130
POINTS = 200
"""Of a curve."""

ON_BAR: dict[str, Any] = {
    "textcoords": "offset points",
    "ha": "center",
    "size": 6,
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.8},
}
"""How the number of runs stands on its bar."""


def bars(
    path: Path,
    title: str,
    estimates: Mapping[str, Estimate],
    *,
    label: str,
    beside: Mapping[str, float] | None = None,
    citation: str = "",
) -> None:
    """A bar for each name, with its interval and its number of runs.

    Args:
        path: of the PNG.
        title: above.
        estimates: by name.
        label: of the axis.
        beside: published figures of some names, drawn beside them.
        citation: of the published figures.
    """
    names, beside = list(estimates), beside or {}
    place, width = np.arange(len(names)), 0.38 if beside else 0.6
    figure, axes = plt.subplots(figsize=(max(4.5, 1.1 * len(names) + 1.5), 3.4))
    shift = width / 2 if beside else 0.0
    means = [estimates[name].mean for name in names]
    widths = np.nan_to_num([estimates[name].half_width for name in names])
    axes.bar(place + shift, means, width, color=OWN_COLOR, yerr=widths, capsize=3, label="here")
    if beside:
        heights = [beside.get(name, np.nan) for name in names]
        axes.bar(place - shift, heights, width, color=PUBLISHED_COLOR, label=citation)
        _legend(axes)
    for x, name in zip(place, names, strict=True):
        estimate = estimates[name]
        note = f"{estimate.runs} runs\n{estimate.seeds} seeds"
        axes.annotate(note, (x + shift, 0), (0, 2), **ON_BAR)
    axes.set_xticks(place, names, rotation=25, ha="right", size=8)
    axes.set_ylabel(label)
    axes.set_title(title, size=10)
    _save(figure, path)


def curves(path: Path, title: str, rows_by_name: Mapping[str, Sequence[Mapping[str, Any]]]) -> None:
    """Success rate over training time, a line for each name: the mean over seeds, with interval."""
    figure, axes = plt.subplots(figsize=(5.6, 3.4))
    longest = max(row["train_seconds"] for rows in rows_by_name.values() for row in rows)
    seconds = np.linspace(0, longest, POINTS)
    for name, rows in rows_by_name.items():
        seeds = sorted({row["seed"] for row in rows})
        per_seed = np.array(
            [
                np.mean([curve_at(r["curve"], seconds) for r in rows if r["seed"] == s], axis=0)
                for s in seeds
            ]
        )
        mean, width = np.array([interval(column) for column in per_seed.T.tolist()]).T
        (line,) = axes.plot(seconds, mean, label=f"{name} ({len(rows)} runs, {len(seeds)} seeds)")
        if len(seeds) > 1:
            low, high = np.clip([mean - width, mean + width], 0, 1)
            axes.fill_between(seconds, low, high, color=line.get_color(), alpha=0.2)
    axes.set_xlabel("training time [s]")
    axes.set_ylabel("success rate")
    axes.set_ylim(-0.02, 1.02)
    axes.set_title(title, size=10)
    _legend(axes)
    _save(figure, path)


def sweep(
    path: Path,
    title: str,
    estimates: Mapping[int, Estimate],
    *,
    label: str,
    beside: Mapping[int, float] | None = None,
    citation: str = "",
) -> None:
    """A quantity over the horizon [steps], with its intervals and numbers of runs."""
    figure, axes = plt.subplots(figsize=(5.6, 3.4))
    steps = sorted(estimates)
    means = [estimates[step].mean for step in steps]
    widths = np.nan_to_num([estimates[step].half_width for step in steps])
    axes.errorbar(steps, means, widths, color=OWN_COLOR, marker="o", capsize=3, label="here")
    if beside:
        given = sorted(beside)
        heights = [beside[step] for step in given]
        axes.plot(given, heights, "s--", color="#888e99", label=citation)
        _legend(axes)
    for step, mean in zip(steps, means, strict=True):
        note = f"{estimates[step].runs} runs"
        axes.annotate(note, (step, mean), (0, -12), textcoords="offset points", size=6)
    axes.set_ylim(0, 1.15 * max(means + list((beside or {}).values())))
    axes.set_xlabel("horizon T [steps]")
    axes.set_ylabel(label)
    axes.set_title(title, size=10)
    _save(figure, path)


def _legend(axes: Any) -> None:
    """Below the axes, where it hides nothing."""
    axes.legend(fontsize=7, loc="upper center", bbox_to_anchor=(0.5, -0.28), ncols=2, frameon=False)


def _save(figure: Any, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=DPI)
    plt.close(figure)
