"""Variants of a method: sources of schedules, parts of state and reward (Table 1), and pieces."""

from collections.abc import Mapping
from typing import Any

from studio.bench.figures import bars
from studio.bench.published import published
from studio.bench.report.page import Page
from studio.bench.report.rows import (
    Row,
    Rows,
    budget,
    by,
    different,
    estimates,
    is_stretched,
    task_rates,
)

WHOLE = ("default", "all")
"""Variants from which nothing is left out."""


def ablations(page: Page, rows: Rows) -> None:
    """A section for each robot, method, mode and budget of which there are several variants."""
    own = [row for row in rows if not is_stretched(row)]
    for (robot, method, mode, limit), part in by(own, _setting).items():
        scratch = [row for row in part if row["weights"] == "none"]
        if len(different(scratch, "variant")) < 2:
            continue
        key = f"variants-{robot}-{method}-{mode}"
        page.heading(f"Variants of {method} on {robot}, {mode} mode: {limit}")
        _table(page, f"{key}-sources", "Sources of schedules (Table 1a)", part, _sources())
        _table(page, f"{key}-parts", "Parts of state and reward (Table 1b)", part, _parts())
        known = {**_sources(), **_parts()}
        pieces = [row for row in part if row["variant"] not in known or _is_whole(row)]
        _table(page, f"{key}-pieces", "Pieces left out, one at a time", pieces, None)


def _table(page: Page, key: str, title: str, rows: Rows, known: Mapping[str, float] | None) -> None:
    """Bars and a table of the variants that stand in a published table, or of all."""
    if known is not None:
        chosen = [row for row in rows if row["variant"] in known or _is_whole(row)]
        rows = [row for row in chosen if row["weights"] == "none"]
    places = {label: place for place, label in enumerate(known or {})}

    def place(row: Row) -> tuple[int, str]:
        return -1 if _is_whole(row) else places.get(row["variant"], 0), _label(row)

    variants = by(sorted(rows, key=place), _label)
    found = estimates(variants, "success_rate")
    if len(found) < 2:
        return
    whole = None if known is None else known["default"]
    beside = {} if known is None else {x: known.get(x, whole) for x in found}
    given = {label: rate for label, rate in beside.items() if rate is not None}
    page.figure(
        key,
        title,
        lambda path: bars(
            path, found, label="success rate", beside=given, citation=published().citation, most=1.0
        ),
    )
    columns = {"here": found, **({"published": given} if given else {}), **_beyond(variants)}
    lines = [(x, *(column.get(x) for column in columns.values())) for x in found]
    page.table(key, ("", *columns), lines)


def _beyond(variants: Mapping[str, Rows]) -> dict[str, dict[str, Any]]:
    """Further columns: success on each of several tasks, and the mean robustness."""
    rates = task_rates(variants)
    columns = rates if len(rates) > 1 else {}
    finite = {
        x: [row for row in rows if row["robustness_mean"] is not None]
        for x, rows in variants.items()
    }
    shown = {x: rows for x, rows in finite.items() if rows}
    return {**columns, "robustness [m]": estimates(shown, "robustness_mean")}


def _is_whole(row: Row) -> bool:
    return row["variant"] in WHOLE


def _label(row: Row) -> str:
    return row["variant"] if row["weights"] == "none" else f"{row['variant']}, shipped weights"


def _setting(row: Row) -> tuple[str, str, str, str]:
    return row["robot"], row["method"], row["mode"], budget(row)


def _sources() -> dict[str, float]:
    return {label: pair[0] for label, pair in published().sampling.items()}


def _parts() -> dict[str, float]:
    return {label: pair[0] for label, pair in published().parts.items()}
