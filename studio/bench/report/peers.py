"""Robustness by other libraries and by ours, in time."""

from studio.bench.report.page import Cell, Page
from studio.bench.report.rows import Rows


def peers(page: Page, rows: Rows) -> None:
    """A table of all comparisons that were made."""
    lines: list[tuple[Cell, ...]] = []
    for row in sorted(rows, key=lambda row: row["method"]):
        for case in row["cases"] or []:
            lines.append(
                (
                    row["method"],
                    case["formula"],
                    1000 * case["seconds"],
                    1000 * case["own_seconds"],
                    case["seconds"] / case["own_seconds"],
                    1000 * case["first_seconds"],
                    1000 * case["own_first_seconds"],
                    case["first_seconds"] / case["own_first_seconds"],
                    f"{case['difference']:.1e}",
                )
            )
    if not lines:
        return
    page.heading("Robustness by other libraries")
    page.text(
        "512 traces of 101 samples, in milliseconds; the least of five evaluations, and the first "
        "with compilation or whatever else is done once. stljax is held against ours under JAX, "
        "compiled; the others against ours on NumPy arrays."
    )
    head = ("library", "formula", "its time", "ours", "factor", "its first", "our first", "factor")
    page.table("peers-robustness", (*head, "difference"), lines)
