"""The report's figures, in a light and a dark theme."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from textwrap import wrap
from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib import rcsetup

from studio.bench.statistics import Estimate, curve_at, interval

DPI = 130
LONGEST = 13
"""Characters of a line below a bar."""

POINTS = 200
"""Of a curve."""

OWN, PUBLISHED, SECOND = "#4c86c6", "#9aa4b2", "#e08a3c"
CYCLE = ("#4c86c6", "#e08a3c", "#5aa469", "#c65f5f", "#8f74c2", "#a0785a", "#d17fb5", "#8a929e")

THEMES: dict[str, dict[str, str]] = {
    "light": {"ink": "#1c2430", "ground": "#ffffff", "grid": "#e4e8ee"},
    "dark": {"ink": "#dfe4ea", "ground": "#14181e", "grid": "#2b323c"},
}
"""Colours of the page's themes."""


@contextmanager
def themed(name: str) -> Iterator[None]:
    """Figures that are drawn meanwhile have the colours of a theme."""
    theme = THEMES[name]
    style: dict[Any, Any] = {
        **dict.fromkeys(
            ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color"),
            theme["ink"],
        ),
        **dict.fromkeys(
            ("figure.facecolor", "axes.facecolor", "savefig.facecolor"), theme["ground"]
        ),
        "grid.color": theme["grid"],
        "axes.grid": True,
        "axes.grid.axis": "y",
        "axes.axisbelow": True,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.prop_cycle": rcsetup.cycler(color=CYCLE),
        "font.size": 9,
    }
    with plt.rc_context(style):
        yield


def bars(
    path: Path,
    estimates: Mapping[str, Estimate],
    *,
    label: str,
    beside: Mapping[str, float] | None = None,
    citation: str = "",
    most: float | None = None,
) -> None:
    """A bar for each name, with its interval and its number of runs below.

    Args:
        path: of the PNG.
        estimates: by name.
        label: of the axis.
        beside: published figures of some names, drawn beside them.
        citation: of the published figures.
        most: that a value can be.
    """
    names, beside = list(estimates), beside or {}
    place, width = np.arange(len(names)), 0.38 if beside else 0.6
    figure, axes = plt.subplots(figsize=(max(4.5, 0.95 * len(names) + 1.2), 3.6))
    shift = width / 2 if beside else 0.0
    means = np.array([estimates[name].mean for name in names])
    widths = np.nan_to_num([estimates[name].half_width for name in names])
    low, high = np.minimum(widths, means), widths
    if most is not None:
        high = np.minimum(widths, most - means)
        axes.set_ylim(0, 1.04 * most)
    axes.bar(place + shift, means, width, color=OWN, label="here")
    seen = widths > 0
    whiskers = {"fmt": "none", "ecolor": plt.rcParams["text.color"], "capsize": 3, "lw": 1}
    axes.errorbar((place + shift)[seen], means[seen], np.array([low, high])[:, seen], **whiskers)
    if beside:
        heights = [beside.get(name, np.nan) for name in names]
        axes.bar(place - shift, heights, width, color=PUBLISHED, label=citation)
        _legend(axes)
    axes.set_xticks(place, [_named(name, estimates[name]) for name in names], size=7.5)
    axes.tick_params(axis="x", length=0)
    axes.set_ylabel(label)
    _save(figure, path)


def curves(
    path: Path,
    rows_by_name: Mapping[str, Sequence[Mapping[str, Any]]],
    *,
    clock: str = "seconds",
    label: str = "training time [s]",
) -> None:
    """Success over training time, a line for each name: the mean over seeds, with interval.

    Args:
        path: of the PNG.
        rows_by_name: rows of the store.
        clock: column of the curves that is the time, `seconds` or `cpu_seconds`.
        label: of the time.
    """
    figure, axes = plt.subplots(figsize=(6.4, 4.2))
    longest = max(row[f"train_{clock}"] for rows in rows_by_name.values() for row in rows)
    seconds = np.linspace(0, longest, POINTS)
    for name, rows in rows_by_name.items():
        seeds = sorted({row["seed"] for row in rows})
        per_seed = np.array(
            [
                np.mean(
                    [curve_at(r["curve"], seconds, clock) for r in rows if r["seed"] == s], axis=0
                )
                for s in seeds
            ]
        )
        mean, width = np.array([interval(column) for column in per_seed.T.tolist()]).T
        (line,) = axes.plot(seconds, mean, label=f"{name} ({_counts(len(rows), len(seeds))})")
        if len(seeds) > 1:
            low, high = np.clip([mean - width, mean + width], 0, 1)
            axes.fill_between(seconds, low, high, color=line.get_color(), alpha=0.15, lw=0)
    axes.set_xlabel(label)
    axes.set_ylabel("success rate")
    axes.set_ylim(-0.02, 1.04)
    _legend(axes)
    _save(figure, path)


def sweep(
    path: Path,
    estimates: Mapping[int, Estimate],
    *,
    label: str,
    beside: Mapping[int, float] | None = None,
    citation: str = "",
    most: float | None = None,
) -> None:
    """A quantity over the horizon [steps], with its intervals and numbers of runs."""
    figure, axes = plt.subplots(figsize=(6.4, 3.6))
    steps = sorted(estimates)
    places = np.arange(len(steps))
    means = np.array([estimates[step].mean for step in steps])
    widths = np.nan_to_num([estimates[step].half_width for step in steps])
    high = widths if most is None else np.minimum(widths, most - means)
    whiskers = np.array([np.minimum(widths, means), high])
    axes.errorbar(places, means, whiskers, color=OWN, marker="o", capsize=3, label="here")
    if beside and not beside.keys().isdisjoint(steps):
        given = [(place, beside[step]) for place, step in enumerate(steps) if step in beside]
        axes.plot(*zip(*given, strict=True), "s--", color=PUBLISHED, label=citation)
        _legend(axes)
    counts = [_counts(estimates[step].runs, estimates[step].seeds, "\n") for step in steps]
    labels = [f"{step}\n{count}" for step, count in zip(steps, counts, strict=True)]
    axes.set_xticks(places, labels, size=7.5)
    axes.set_ylim(0, 1.04 * most if most is not None else 1.2 * means.max())
    axes.set_xlabel("horizon T [steps]")
    axes.set_ylabel(label)
    _save(figure, path)


def scatters(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """The critic's scores against robustness, and the success above each score, a task each."""
    figure, grid = _grid(len(rows))
    for row, axes in zip(rows, grid, strict=False):
        score = np.asarray(row["critic_scores"])
        value = np.asarray(row["critic_robustness"])
        axes.scatter(score, value, s=3, color=OWN, alpha=0.35, lw=0)
        axes.axhline(0, color=plt.rcParams["text.color"], lw=0.6)
        order = np.argsort(-score)
        share = np.cumsum(value[order] >= 0) / np.arange(1, score.size + 1)
        other = axes.twinx()
        other.plot(score[order], share, color=SECOND, lw=1.4)
        other.set_ylim(-0.03, 1.05)
        other.grid(False)
        other.tick_params(colors=SECOND, labelsize=7)
        axes.tick_params(labelsize=7)
        axes.set_title(f"{row['task']}, seed {row['seed']}", size=8.5)
    figure.supxlabel("critic", size=9)
    figure.supylabel("robustness [m] (dots)", size=9, color=OWN)
    figure.text(1.0, 0.5, "success above (line)", rotation=270, va="center", color=SECOND, size=9)
    _save(figure, path)


def maps(path: Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """The critic's scores over two times, a task each."""
    figure, grid = _grid(len(rows))
    for row, axes in zip(rows, grid, strict=False):
        found = row["critic_map"]
        first, second = np.asarray(found["first"]), np.asarray(found["second"])
        scores = np.asarray(found["scores"], float).reshape(second.size, first.size)
        axes.grid(False)
        axes.imshow(
            np.ma.masked_invalid(scores),
            origin="lower",
            aspect="auto",
            extent=(first[0] - 0.5, first[-1] + 0.5, second[0] - 0.5, second[-1] + 0.5),
        )
        axes.tick_params(labelsize=7)
        axes.set_title(f"{row['task']}, seed {row['seed']}", size=8.5)
    figure.supxlabel("first time variable [steps]", size=9)
    figure.supylabel("second [steps]", size=9)
    _save(figure, path)


def _grid(count: int) -> tuple[Any, list[Any]]:
    """Axes for so many small pictures, five in a row; those that are left over are not there."""
    columns = min(count, 5)
    lines = -(-count // columns)
    size = (max(4.0, 2.1 * columns), 2.0 * lines + 0.6)
    figure, grid = plt.subplots(lines, columns, figsize=size, squeeze=False)
    found = grid.ravel().tolist()
    for axes in found[count:]:
        axes.remove()
    return figure, found[:count]


def _named(name: str, estimate: Estimate) -> str:
    """A bar's name, with its counts."""
    lines = [line for part in name.split(", ") for line in wrap(part, LONGEST)]
    return "\n".join([*lines, _counts(estimate.runs, estimate.seeds, "\n")])


def _counts(runs: int, seeds: int, between: str = ", ") -> str:
    ran = "1 run" if runs == 1 else f"{runs} runs"
    return f"{ran}{between}{'1 seed' if seeds == 1 else f'{seeds} seeds'}"


def _legend(axes: Any) -> None:
    """Above the axes, where it hides nothing."""
    where = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.01)}
    axes.legend(fontsize=7.5, ncols=2, frameon=False, **where)


def _save(figure: Any, path: Path) -> None:
    figure.tight_layout()
    figure.savefig(path, dpi=DPI, bbox_inches="tight", pad_inches=0.12)
    plt.close(figure)
