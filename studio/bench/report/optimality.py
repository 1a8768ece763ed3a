"""Robustness as a share of the exact planner's, from the middle of the initial set."""

from studio.bench.report.page import Cell, Page
from studio.bench.report.rows import OURS, Rows, budget, by, main, name
from studio.bench.statistics import interval, over_seeds

EXACT = "exact"


def optimality(page: Page, rows: Rows) -> None:
    """A table of all tasks that the exact planner has seen."""
    optima = {row["task"]: row for row in rows if row["method"] == EXACT}
    trained = [
        row for row in main(rows) if row["task"] in optima and row["middle_robustness"] is not None
    ]
    named = by(trained, lambda row: f"{name(row)} ({budget(row)})")
    if not optima or not named:
        return
    page.heading("Optimality")
    page.text(
        "Robustness from the middle of the initial set, in metres, and as a share of the exact "
        "planner's trace. Where its search ran out of time before a proof, the optimum may be as "
        "high as the bound."
    )
    head = ("task", "exact", "proved", "bound", "seconds")
    page.table(
        "optimality-exact",
        head,
        [
            (t, r["robustness_mean"], r["stopped"], r["bound"], r["train_seconds"])
            for t, r in sorted(optima.items())
        ],
    )
    lines: list[tuple[Cell, ...]] = []
    means: list[tuple[Cell, ...]] = []
    for label, part in named.items():
        shares = []
        for task, own in sorted(by(part, lambda row: row["task"]).items()):
            best = optima[task]["robustness_mean"]
            found = over_seeds(own, "middle_robustness")
            shares += [found.mean / best] if best else []
            if part[0]["method"] in OURS and best:
                lines.append((label, task, found, shares[-1]))
        if shares:
            means.append((label, len(shares), interval(shares)[0]))
    page.table("optimality-means", ("", "tasks", "mean share of the optimum"), means)
    page.table("optimality", ("", "task", "robustness [m]", "share of the optimum"), lines)
