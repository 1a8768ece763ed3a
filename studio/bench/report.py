"""A page about a store: figures and tables with intervals over seeds, the paper's beside them.

DIR/report/index.html    the page
DIR/report/*.png         its figures
DIR/report/summary.json  every number on it
"""

import json
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

from core.checkpoint import write_atomically
from core.errors import UserError
from studio.bench.figures import bars, curves, sweep
from studio.bench.matrix import DEFAULT
from studio.bench.published import published
from studio.bench.statistics import Estimate, over_seeds
from studio.bench.store import Store

Row = Mapping[str, Any]
Rows = Sequence[Row]

GROUPS = {"two-layer": range(1, 6), "multi-layer": range(6, 11)}
"""The paper's groups of formulas, by the number of the task."""

STYLE = (
    "body{font:15px/1.5 system-ui;max-width:60rem;margin:2rem auto;padding:0 1rem}"
    "table{border-collapse:collapse}td,th{border:1px solid #ccd;padding:.2rem .6rem}"
    "img{max-width:100%}figure{margin:1rem 0}"
)


def write_report(store: Store) -> Path:
    """Write the report of a store; returns the page.

    Raises:
        UserError: the store is empty or damaged, or the folder cannot be written.
    """
    rows = store.rows()
    if not any(row["status"] == "finished" for row in rows):
        raise UserError(f"{store.folder}: no run is finished")
    report = _Report(store.folder / "report")
    try:
        report.folder.mkdir(parents=True, exist_ok=True)
        report.write(rows)
    except OSError as error:
        raise UserError(f"{report.folder}: cannot be written: {error.strerror}") from error
    return report.folder / "index.html"


class _Report:
    """Collects the parts of a page and the numbers on it."""

    def __init__(self, folder: Path):
        self.folder = folder
        self._parts: list[str] = []
        self._summary: dict[str, Any] = {}

    def write(self, rows: Rows) -> None:
        """Write all files."""
        done = [row for row in rows if row["status"] == "finished"]
        self._origin(done)
        for robot in _different(done, "robot"):
            self._robot(robot, [row for row in done if row["robot"] == robot])
        self._variants(done)
        self._horizons(done)
        self._refused([row for row in rows if row["status"] == "refused"])
        page = (
            "<!doctype html><html lang=en><meta charset=utf-8><title>tgpo-bench</title>"
            f"<style>{STYLE}</style><h1>Benchmark</h1>{''.join(self._parts)}</html>\n"
        )
        summary = json.dumps(self._summary, indent=1, sort_keys=True) + "\n"
        write_atomically(self.folder / "summary.json", summary.encode())
        write_atomically(self.folder / "index.html", page.encode())

    def _origin(self, rows: Rows) -> None:
        machines = {json.dumps(row["machine"], sort_keys=True) for row in rows}
        versions = {json.dumps(row["versions"], sort_keys=True) for row in rows}
        revisions = _different(rows, "revision")
        self._summary["runs"] = len(rows)
        self._summary["machines"] = [json.loads(text) for text in sorted(machines)]
        self._summary["versions"] = [json.loads(text) for text in sorted(versions)]
        self._summary["revisions"] = revisions
        lines = [f"{len(rows)} runs, {_hours(rows):.1f} hours of processes."]
        lines += [", ".join(json.loads(text).values()) for text in sorted(machines)]
        lines += [", ".join(f"{k} {v}" for k, v in json.loads(t).items()) for t in sorted(versions)]
        lines += [f"Revision {text or 'unknown'}" for text in revisions]
        lines += [
            "Whiskers and bands are Student-t 95 % intervals over seeds, of which each counts with "
            "its mean over tasks; with one seed there is none. The paper's scenes are not "
            f"published: its figures ({published().citation}) are for others."
        ]
        self._parts += [f"<p>{'<br>'.join(map(escape, lines))}</p>"]

    def _robot(self, robot: str, rows: Rows) -> None:
        """Success bars, curves and training time of the preset methods of a robot."""
        rows = _main(rows)
        if not rows:
            return
        self._parts.append(f"<h2>{escape(robot)}</h2>")
        named = _by(rows, _name)
        beside = {name: published().success.get(robot, {}).get(name) for name in named}
        known = {name: rate for name, rate in beside.items() if rate is not None}
        for group, part in {"all": rows, **_groups(rows)}.items():
            estimates = _estimates(_by(part, _name), "success_rate")
            title = f"{robot}: success, {group} tasks ({len(_different(part, 'task'))})"
            shown = known if group == "all" else {}
            self._bars(f"success-{robot}-{group}", title, estimates, "success rate", shown)
        self._figure(f"curves-{robot}", lambda path: curves(path, f"{robot}: success", named))
        seconds = _estimates(named, "train_seconds")
        self._bars(f"seconds-{robot}", f"{robot}: training time", seconds, "seconds", {})

    def _variants(self, rows: Rows) -> None:
        """Each variant of a method on a robot, its preset included."""
        scratch = [row for row in rows if row["weights"] == "none" and not _stretched(row)]
        for (robot, method, mode), part in _by(scratch, _method).items():
            if len(_different(part, "variant")) < 2:
                continue
            estimates = _estimates(_by(part, lambda row: row["variant"]), "success_rate")
            known = {name: pair[0] for name, pair in published().sampling.items()}
            beside = known if (robot, method) == ("linear", "tgpo-star") else {}
            title = f"{robot}: variants of {method}, {mode} mode"
            key = f"variants-{robot}-{method}-{mode}"
            self._bars(key, title, estimates, "success rate", beside)

    def _horizons(self, rows: Rows) -> None:
        """Success and training time by horizon, where there are several of the same tasks."""
        for (robot, method, mode), part in _by(_main(rows, stretched=True), _method).items():
            by_steps = _by(part, lambda row: row["horizon"])
            if len(by_steps) < 2:
                continue
            beside = {int(steps): rate for steps, rate in published().horizon.items()}
            for value, label in (("success_rate", "success rate"), ("train_seconds", "seconds")):
                estimates = _estimates(by_steps, value)
                key, title = f"horizon-{robot}-{method}-{mode}-{value}", f"{robot}, {method}"
                known = beside if value == "success_rate" and robot == "linear" else {}
                self._figure(
                    key,
                    lambda path, e=estimates, t=title, x=label, k=known: sweep(
                        path, t, e, label=x, beside=k, citation=published().citation
                    ),
                )
                self._table(key, {str(steps): e for steps, e in estimates.items()}, {})

    def _refused(self, rows: Rows) -> None:
        if rows:
            said = {(row["method"], row["task"], row["message"]) for row in rows}
            items = "".join(f"<li>{escape(': '.join(map(str, one)))}" for one in sorted(said))
            self._parts.append(f"<h2>Refused</h2><ul>{items}</ul>")
            self._summary["refused"] = [list(one) for one in sorted(said)]

    def _bars(
        self,
        key: str,
        title: str,
        estimates: Mapping[str, Estimate],
        label: str,
        beside: Mapping[str, float],
    ) -> None:
        citation = published().citation
        self._figure(
            key,
            lambda path: bars(
                path, title, estimates, label=label, beside=beside, citation=citation
            ),
        )
        self._table(key, estimates, beside)

    def _figure(self, key: str, draw: Callable[[Path], None]) -> None:
        draw(self.folder / f"{key}.png")
        self._parts.append(f'<figure><img src="{escape(key)}.png" alt="{escape(key)}"></figure>')

    def _table(
        self, key: str, estimates: Mapping[str, Estimate], beside: Mapping[str, float]
    ) -> None:
        self._summary[key] = {
            name: {
                "mean": estimate.mean,
                "half_width": None if estimate.seeds < 2 else estimate.half_width,
                "seeds": estimate.seeds,
                "runs": estimate.runs,
            }
            for name, estimate in estimates.items()
        }
        head = "<tr><th><th>here" + ("<th>published" if beside else "")
        lines = [
            f"<tr><td>{escape(name)}<td>{escape(estimate.text)}"
            + (f"<td>{beside.get(name, '-')}" if beside else "")
            for name, estimate in estimates.items()
        ]
        self._parts.append(f"<table>{head}{''.join(lines)}</table>")


def _main(rows: Rows, *, stretched: bool = False) -> Rows:
    """Runs of presets: those of the tasks as they are, or those with a horizon of their own."""
    own = [row for row in rows if row["variant"] == DEFAULT]
    return [row for row in own if _stretched(row) == stretched]


def _stretched(row: Row) -> bool:
    """Whether a run was asked for with a horizon."""
    return json.loads(row["job"])["horizon"] is not None


def _name(row: Row) -> str:
    """What a bar is called: the method, and what differs from a training from scratch."""
    parts = [row["method"]]
    parts += ["paper mode"] if row["mode"] == "paper" else []
    parts += [f"{row['weights']} weights"] if row["weights"] != "none" else []
    return ", ".join(parts)


def _method(row: Row) -> tuple[str, str, str]:
    return row["robot"], row["method"], row["mode"]


def _groups(rows: Rows) -> Mapping[str, Rows]:
    """The paper's groups of tasks that there are runs of, if there are both."""
    found = {
        group: [row for row in rows if _number(row["task"]) in numbers]
        for group, numbers in GROUPS.items()
    }
    return found if all(found.values()) else {}


def _number(task: str) -> int:
    last = task.rsplit("-", 1)[-1]
    return int(last) if last.isdigit() else 0


def _by(rows: Rows, key: Callable[[Row], Any]) -> dict[Any, list[Row]]:
    found: dict[Any, list[Row]] = defaultdict(list)
    for row in rows:
        found[key(row)].append(row)
    return dict(found)


def _estimates(rows_by_name: Mapping[Any, Rows], value: str) -> dict[Any, Estimate]:
    return {name: over_seeds(rows, value) for name, rows in rows_by_name.items()}


def _different(rows: Iterable[Row], column: str) -> list[str]:
    return sorted({row[column] for row in rows})


def _hours(rows: Rows) -> float:
    return sum(row["wall_seconds"] for row in rows) / 3600
