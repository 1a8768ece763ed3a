"""The report as Markdown, from its summary: `docs/benchmarks.md` and `docs/benchmarks.json`.

What stands below the end mark in the Markdown file is written by hand and kept.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from core.checkpoint import write_atomically
from core.errors import UserError
from studio.bench.report.page import shown_cell

BEGIN = "<!-- written by `tgpo-bench report --docs`: edit nothing up to the end mark -->"
END = "<!-- end of the report -->"
TITLE = "# Benchmarks"


def write_docs(summary: Path, folder: Path) -> Path:
    """Keep a summary in a folder as benchmarks.json, and write benchmarks.md from it.

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
