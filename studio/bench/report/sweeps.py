"""Success and training time by horizon (Fig. 2)."""

from studio.bench.figures import sweep
from studio.bench.published import published
from studio.bench.report.page import Page
from studio.bench.report.rows import Row, Rows, by, clock, estimates, main, name


def horizons(page: Page, rows: Rows) -> None:
    """A section for each robot and method of which there are several horizons."""
    for (robot, label), part in by(main(rows, stretched=True), _setting).items():
        by_steps = by(part, lambda row: row["horizon"])
        if len(by_steps) < 2:
            continue
        own = robot == "linear" and label == "tgpo-star"
        beside = {int(steps): rate for steps, rate in published().horizon.items()} if own else {}
        page.heading(f"Horizons: {label} on {robot}")
        rates = estimates(by_steps, "success_rate")
        wall, cpu = (estimates(by_steps, f"train_{one}") for one in ("seconds", "cpu_seconds"))
        seconds, unit = clock(part)
        spent = cpu if seconds == "cpu_seconds" else wall
        page.figure(
            f"horizon-{robot}-{label}-success",
            "Success by horizon",
            lambda path, e=rates, b=beside: sweep(
                path, e, label="success rate", beside=b, citation=published().citation, most=1.0
            ),
        )
        page.figure(
            f"horizon-{robot}-{label}-seconds",
            "Training time by horizon",
            lambda path, e=spent, u=unit: sweep(path, e, label=f"training time [s], {u}"),
        )
        head = ("steps", "success", "published", "wall-clock [s]", "processor [s]")
        lines = [(s, rates[s], beside.get(s), wall[s], cpu[s]) for s in sorted(by_steps)]
        page.table(f"horizon-{robot}-{label}", head, lines)


def _setting(row: Row) -> tuple[str, str]:
    return row["robot"], name(row)
