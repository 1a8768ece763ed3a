"""The main comparison (Fig. 1, App. A.5): success, curves and training time, robot by robot."""

from core.methods import METHODS
from envs import ENVS
from studio.bench.figures import bars, curves
from studio.bench.published import published
from studio.bench.report.page import Page
from studio.bench.report.rows import (
    OURS,
    Rows,
    budget,
    by,
    clock,
    different,
    estimates,
    groups,
    main,
    name,
    task_rates,
)
from studio.bench.statistics import Estimate, over_seeds

CHAMPION = "tgpo-star"
"""The method that the baselines are held against."""


def beaten(page: Page, rows: Rows) -> None:
    """On which tasks a baseline does better than TGPO* from scratch, first of all."""
    scratch = [row for row in main(rows) if (row["weights"], row["mode"]) == ("none", "studio")]
    lost, compared = [], 0
    for (_, task), part in by(scratch, lambda row: (budget(row), row["task"])).items():
        of_method = estimates(by(part, lambda row: row["method"]), "success_rate")
        rivals = {method: one for method, one in of_method.items() if method not in OURS}
        if CHAMPION not in of_method or not rivals:
            continue
        compared += 1
        own = of_method[CHAMPION]
        lost += [
            (task, budget(part[0]), method, one, own)
            for method, one in rivals.items()
            if one.mean > own.mean
        ]
    if not compared:
        return
    page.heading("Where a baseline is better than TGPO*")
    if not lost:
        page.text(f"On none of {compared} tasks is the mean success of a baseline higher.")
        return
    worse = len({row[:2] for row in lost})
    page.text(f"On {worse} of {compared} tasks the mean success of a baseline is higher:")
    head = ("task", "budget", "baseline", "its success", "TGPO*'s")
    page.table("beaten", head, lost)


def comparison(page: Page, rows: Rows) -> None:
    """A section for each robot and budget, where something is compared or nothing else is.

    A training by the paper's own formulation always has one: whether it succeeds is a question.
    """
    for robot, own in by_robot(main(rows)).items():
        parts = by(own, budget)
        told = {
            limit
            for limit, part in parts.items()
            if len({*map(name, part)}) > 1 or any(row["mode"] == "paper" for row in part)
        }
        for limit in [one for one in parts if one in told] or parts:
            part = parts[limit]
            key = f"{robot}-{''.join(c if c.isalnum() else '-' for c in limit)}"
            page.heading(f"{robot}: {limit}")
            _success(page, key, robot, part)
            _over_time(page, key, robot, part)
            _each_task(page, key, part)


def by_robot(rows: Rows) -> dict[str, Rows]:
    """The shipped robots in their order, then any others."""
    found = by(rows, lambda row: row["robot"])
    return {robot: found[robot] for robot in [*(r for r in ENVS if r in found), *found]}


def _success(page: Page, key: str, robot: str, rows: Rows) -> None:
    known = published().success.get(robot, {})
    columns: dict[str, dict[str, Estimate]] = {}
    for group, part in {"all": rows, **groups(rows)}.items():
        found = columns[group] = estimates(_in_order(part), "success_rate")
        beside = {label: known[label] for label in found if label in known and group == "all"}
        page.figure(
            f"success-{key}-{group}",
            f"{robot}: success on {group} tasks ({len(different(part, 'task'))})",
            lambda path, f=found, b=beside: bars(
                path, f, label="success rate", beside=b, citation=published().citation, most=1.0
            ),
        )
    names = columns.pop("all")
    lines = [
        (label, one, known.get(label), *(found.get(label) for found in columns.values()))
        for label, one in names.items()
    ]
    page.table(f"success-{key}", ("", "all tasks", "published", *columns), lines)


def _over_time(page: Page, key: str, robot: str, rows: Rows) -> None:
    named = _in_order(rows)
    seconds, unit = clock(rows)
    page.figure(
        f"curves-{key}",
        f"{robot}: success over training time",
        lambda path: curves(path, named, clock=seconds, label=f"training time [s], {unit}"),
    )
    found = estimates(named, f"train_{seconds}")
    page.figure(
        f"seconds-{key}",
        f"{robot}: training time until the run ended, evaluations included, compilation not",
        lambda path: bars(path, found, label=f"seconds, {unit}"),
    )
    lines = []
    for label, part in named.items():
        ends = by(part, lambda row: row["stopped"] or "unknown")
        ended = ", ".join(f"{end} {len(ends[end])}" for end in sorted(ends))
        wall, cpu = (over_seeds(part, f"train_{one}") for one in ("seconds", "cpu_seconds"))
        lines.append((label, wall, cpu, ended))
    head = ("", "wall-clock [s]", "processor [s]", "runs by what ended them")
    page.table(f"seconds-{key}", head, lines)


def _each_task(page: Page, key: str, rows: Rows) -> None:
    named = _in_order(rows)
    lines = [(task, *map(rates.get, named)) for task, rates in task_rates(named).items()]
    page.table(f"tasks-{key}", ("mean success over seeds", *named), lines)


def _in_order(rows: Rows) -> dict[str, Rows]:
    """By name, our methods first."""
    order = list(METHODS)

    def place(label: str) -> tuple[int, str]:
        method = label.split(",", 1)[0]
        return (order.index(method) if method in order else len(order), label)

    named = by(rows, name)
    return {label: named[label] for label in sorted(named, key=place)}
