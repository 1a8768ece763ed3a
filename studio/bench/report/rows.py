"""Rows of a store: which belong together, and what a group of them is called."""

import json
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from core.methods import METHODS
from studio.bench.matrix import DEFAULT, PEERS
from studio.bench.statistics import Estimate, over_seeds

Row = Mapping[str, Any]
Rows = Sequence[Row]

LEARNERS = (*METHODS, *PEERS)
"""What learns, and is compared by success."""

GROUPS = {"two-layer": range(1, 6), "multi-layer": range(6, 11)}
"""The paper's groups of formulas, by the number of the task."""

OURS = ("tgpo-star", "tgpo")
"""The methods that are not baselines."""

ENDLESS = 100_000
"""Epochs from which they are no budget."""


def job_of(row: Row) -> dict[str, Any]:
    """What was asked for."""
    return json.loads(row["job"])


def main(rows: Rows, *, stretched: bool = False) -> Rows:
    """Runs of presets: those of the tasks as they are, or those with a horizon of their own."""
    own = [row for row in rows if row["variant"] == DEFAULT and row["method"] in LEARNERS]
    return [row for row in own if is_stretched(row) == stretched]


def is_stretched(row: Row) -> bool:
    """Whether a run was asked for with a horizon."""
    return job_of(row)["horizon"] is not None


def budget(row: Row) -> str:
    """What a run could use up, in words."""
    job = job_of(row)
    parts = [f"{job['seconds']:g} s wall-clock"] if job["seconds"] is not None else []
    if job.get("cpu_seconds") is not None:
        parts.append(f"{job['cpu_seconds']:g} s of the processor")
    if job["epochs"] is not None and job["epochs"] < ENDLESS:
        parts.append(f"{job['epochs']} epochs")
    if job["target"] is None or job["target"] <= 1:
        target = "the default target" if job["target"] is None else f"{job['target']:g}"
        parts.append(f"ends early at {target}")
    return ", ".join(parts) or "the default budget"


def clock(rows: Rows) -> tuple[str, str]:
    """Which seconds were the budget: the columns' ending, and a word."""
    if all(row["stopped"] == "cpu_seconds" or "processor" in budget(row) for row in rows):
        return "cpu_seconds", "processor"
    return "seconds", "wall-clock"


def name(row: Row) -> str:
    """What a bar is called: the method, and what differs from a training from scratch."""
    parts = [row["method"]]
    parts += ["paper mode"] if row["mode"] == "paper" else []
    parts += [f"{row['weights']} weights"] if row["weights"] != "none" else []
    return ", ".join(parts)


def groups(rows: Rows) -> Mapping[str, Rows]:
    """The paper's groups of tasks that there are runs of, if there are both."""
    found = {
        group: [row for row in rows if number(row["task"]) in numbers]
        for group, numbers in GROUPS.items()
    }
    return found if all(found.values()) else {}


def number(task: str) -> int:
    """Of a task among its robot's, 0 for a demo."""
    last = task.rsplit("-", 1)[-1]
    return int(last) if last.isdigit() else 0


def by(rows: Rows, key: Callable[[Row], Any]) -> dict[Any, list[Row]]:
    """Rows of the same key together, in order of appearance."""
    found: dict[Any, list[Row]] = defaultdict(list)
    for row in rows:
        found[key(row)].append(row)
    return dict(found)


def estimates(rows_by_name: Mapping[Any, Rows], value: str) -> dict[Any, Estimate]:
    """The mean of a column of each group."""
    return {label: over_seeds(rows, value) for label, rows in rows_by_name.items()}


def task_rates(rows_by_name: Mapping[Any, Rows]) -> dict[str, dict[Any, float]]:
    """Mean success over seeds on each task, of the groups that have runs on it."""
    found: dict[str, dict[Any, float]] = {}
    for task in different([row for rows in rows_by_name.values() for row in rows], "task"):
        parts = {
            label: [row for row in rows if row["task"] == task]
            for label, rows in rows_by_name.items()
        }
        found[task] = {
            label: over_seeds(part, "success_rate").mean for label, part in parts.items() if part
        }
    return found


def different(rows: Iterable[Row], column: str) -> list[Any]:
    """Values of a column, each once."""
    return sorted({row[column] for row in rows})
