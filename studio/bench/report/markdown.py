"""The report as Markdown, from its summary, with the runs that it speaks of.

`docs/benchmarks.md`, `docs/benchmarks.json` (the summary) and `docs/benchmarks.parquet` (the runs).

What stands below the end mark in the Markdown file is written by hand and kept.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from core.checkpoint import write_atomically
from core.errors import UserError
from studio.bench.report.page import shown_cell
from studio.bench.store import write_rows

BEGIN = "<!-- written by `tgpo-bench report --docs`: edit nothing up to the end mark -->"
END = "<!-- end of the report -->"
TITLE = "# Benchmarks"


def write_docs(summary: Path, folder: Path, rows: Sequence[Mapping[str, Any]]) -> Path:
    """Keep a summary and its runs in a folder, and write benchmarks.md from the summary.

    Raises:
        UserError: the folder cannot be written, or its Markdown has lost its marks.
    """
    page = folder / "benchmarks.md"
    try:
        text = summary.read_text(encoding="utf-8")
        before = (
            page.read_text(encoding="utf-8") if page.exists() else f"{TITLE}\n\n{BEGIN}\n{END}\n"
        )
        if BEGIN not in before or END not in before:
            raise UserError(f"{page}: the lines {BEGIN!r} and {END!r} must stand in it")
        head, tail = before.split(BEGIN)[0], before.split(END, 1)[1]
        written = f"{head}{BEGIN}\n\n{markdown(json.loads(text))}\n{END}{tail}"
        write_rows(folder / "benchmarks.parquet", rows)
        write_atomically(folder / "benchmarks.json", text.encode())
        write_atomically(page, written.encode())
    except OSError as error:
        raise UserError(f"{folder}: cannot be written: {error.strerror}") from error
    return page


def markdown(summary: Mapping[str, Any]) -> str:
    """The parts of a summary but the figures."""
    return "\n\n".join(filter(None, map(_part, summary["parts"]))) + "\n"


def _part(part: Mapping[str, Any]) -> str:
    match part:
        case {"kind": "heading", "level": level, "text": text}:
            return f"{'#' * level} {text}"
        case {"kind": "text", "text": text}:
            return text
        case {"kind": "list", "items": items}:
            return "\n".join(f"* {item}" for item in items)
        case {"kind": "figure"}:
            return ""
        case {"head": head, "rows": rows}:
            lines = [
                head,
                ["---"] * len(head),
                *([shown_cell(cell) for cell in row] for row in rows),
            ]
            return "\n".join(
                f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines
            )
    raise AssertionError(part)
