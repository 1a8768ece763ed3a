"""Writes the report of a store.

DIR/report/index.html    the page
DIR/report/*.png         its figures, each once more for dark screens
DIR/report/summary.json  every number on it, and its parts
"""

import json
from pathlib import Path

from core.checkpoint import write_atomically
from core.errors import UserError
from studio.bench.published import published
from studio.bench.report.ablations import ablations
from studio.bench.report.comparison import beaten, comparison
from studio.bench.report.critic import critics
from studio.bench.report.optimality import optimality
from studio.bench.report.page import Page, html
from studio.bench.report.peers import peers
from studio.bench.report.rows import Rows, by, different
from studio.bench.report.sweeps import horizons
from studio.bench.store import Store
from studio.runs.json_documents import plain

SECTIONS = (beaten, comparison, ablations, horizons, critics, optimality, peers)
"""What stands on the page, in this order."""

TITLE = "Benchmark of TGPO Studio"


def write_report(store: Store) -> Path:
    """Write the report of a store; returns the page.

    Raises:
        UserError: the store is empty or damaged, or the folder cannot be written.
    """
    rows = store.rows()
    done = [row for row in rows if row["status"] == "finished"]
    if not done:
        raise UserError(f"{store.folder}: no run is finished")
    folder = store.folder / "report"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        page = Page(folder)
        _origin(page, done)
        for section in SECTIONS:
            section(page, done)
        _refused(page, [row for row in rows if row["status"] == "refused"])
        summary = json.dumps(plain(_summary(page, done)), indent=1) + "\n"
        write_atomically(folder / "summary.json", summary.encode())
        write_atomically(folder / "index.html", html(TITLE, page.parts).encode())
    except OSError as error:
        raise UserError(f"{folder}: cannot be written: {error.strerror}") from error
    return folder / "index.html"


def _summary(page: Page, rows: Rows) -> dict[str, object]:
    return {"format": 1, "runs": len(rows), "parts": page.parts}


def _origin(page: Page, rows: Rows) -> None:
    """What was run, where and with what."""
    hours = sum(row["wall_seconds"] for row in rows) / 3600
    days = sorted({row["started"][:10] for row in rows})
    when = days[0] if len(days) == 1 else f"{days[0]} to {days[-1]}"
    page.text(f"{len(rows)} runs, {hours:.1f} hours of processes, {when}.")
    machines = by(rows, lambda row: json.dumps([row["machine"], row["concurrent"], row["cores"]]))
    for text, part in sorted(machines.items()):
        machine, concurrent, cores = json.loads(text)
        kept = "" if cores is None else f", each on {_counted(cores, 'core')}"
        at_once = "" if concurrent is None else f"; {concurrent} at a time{kept}"
        said = ", ".join(f"{name} {value}" for name, value in machine.items())
        page.text(f"{_counted(len(part), 'run')} on {said}{at_once}.")
    for text in sorted({json.dumps(row["versions"], sort_keys=True) for row in rows}):
        page.text(", ".join(f"{name} {value}" for name, value in json.loads(text).items()))
    revisions = ", ".join(text or "unknown" for text in different(rows, "revision"))
    page.text(f"Revision {revisions}.")
    page.text(
        "Whiskers and bands are Student-t 95 % intervals over seeds, of which each counts with its "
        "mean over tasks; with one seed there is none. Success is the share of 512 fresh initial "
        "states whose trace satisfies the formula; baselines have the best of ten attempts, TGPO "
        "has one. A run that ends early counts with the success that it then has, and in curves "
        "with its last evaluation. The paper's scenes are not published: its figures "
        f"({published().citation}) are for others, on other machines and budgets."
    )


def _refused(page: Page, rows: Rows) -> None:
    """What methods and scenes do not allow."""
    if rows:
        said = sorted({f"{row['method']}: {row['task']}: {row['message']}" for row in rows})
        page.heading("Refused")
        page.listed(said)


def _counted(count: int, what: str) -> str:
    return f"{count} {what}" if count == 1 else f"{count} {what}s"
