"""A page as a list of parts: headings, texts, tables and figures.

The parts are plain values, so that the summary keeps them, and Markdown can be made of them later.
A cell of a table is a text, a number, None, or an estimate as a table of its fields.
"""

from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from studio.bench.figures import THEMES, themed
from studio.bench.statistics import Estimate

Cell = str | int | float | None | Estimate

FOLDED = 14
"""Rows from which a table is folded."""

STYLE = """
:root{color-scheme:light dark;--ink:#1c2430;--dim:#5d6878;--line:#d9dee6;--ground:#fff;
--stripe:#f6f8fa}
@media(prefers-color-scheme:dark){:root{--ink:#e4e8ee;--dim:#98a3b3;--line:#343c48;--ground:#14181e;
--stripe:#1b2129}}
body{font:15px/1.55 system-ui,sans-serif;max-width:66rem;margin:2rem auto;padding:0 1.2rem;
color:var(--ink);background:var(--ground)}
h1{font-size:1.7rem}h2{margin-top:2.6rem;border-bottom:1px solid var(--line);padding-bottom:.25rem}
.scroll{overflow-x:auto}table{border-collapse:collapse;font-size:.9rem;margin:.6rem 0 1.2rem;
font-variant-numeric:tabular-nums}th{text-align:left;font-weight:600}
td,th{border-bottom:1px solid var(--line);padding:.25rem .8rem .25rem 0;white-space:nowrap;
vertical-align:top}tr:nth-child(even) td{background:var(--stripe)}
figure{margin:1.6rem 0 .4rem}img{max-width:100%}figcaption{font-weight:600;margin-bottom:.3rem}
nav a{margin-right:1rem}a,summary{color:var(--dim)}summary{cursor:pointer}
"""


class Page:
    """Collects parts; figures are drawn as they come."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.parts: list[dict[str, Any]] = []

    def heading(self, text: str, level: int = 2) -> None:
        """Begin a section."""
        self.parts.append({"kind": "heading", "level": level, "text": text})

    def text(self, text: str) -> None:
        """A paragraph."""
        self.parts.append({"kind": "text", "text": text})

    def listed(self, items: Sequence[str]) -> None:
        """Items with a dot before each."""
        self.parts.append({"kind": "list", "items": list(items)})

    def table(self, key: str, head: Sequence[str], rows: Sequence[Sequence[Cell]]) -> None:
        """A table, known by its key."""
        kept = [[plain_cell(cell) for cell in row] for row in rows]
        self.parts.append({"kind": "table", "key": key, "head": list(head), "rows": kept})

    def figure(self, key: str, caption: str, draw: Callable[[Path], None]) -> None:
        """A figure in both themes; `draw` writes a PNG."""
        for theme in THEMES:
            with themed(theme):
                draw(self.folder / f"{key}{suffix(theme)}.png")
        self.parts.append({"kind": "figure", "key": key, "caption": caption})


def plain_cell(cell: Cell) -> Any:
    """A cell as JSON keeps it."""
    if isinstance(cell, Estimate):
        width = None if np.isnan(cell.half_width) else cell.half_width
        return {**cell._asdict(), "half_width": width}
    return cell


def shown_cell(cell: Any) -> str:
    """A cell as it is read: numbers with three decimals, estimates with interval and counts."""
    match cell:
        case None:
            return "-"
        case {"mean": mean, "half_width": width, "seeds": seeds, "runs": runs}:
            return Estimate(mean, float("nan") if width is None else width, seeds, runs).text
        case float():
            return f"{cell:.3f}"
    return str(cell)


def suffix(theme: str) -> str:
    """Of a figure's name."""
    return "" if theme == "light" else f"-{theme}"


def html(title: str, parts: Sequence[dict[str, Any]]) -> str:
    """The page."""
    tops = [part["text"] for part in parts if part["kind"] == "heading" and part["level"] == 2]
    links = "".join(f'<a href="#{anchor(text)}">{escape(text)}</a>' for text in tops)
    return (
        '<!doctype html><html lang=en><meta charset=utf-8><meta name=viewport content="'
        f'width=device-width"><title>tgpo-bench</title><style>{STYLE}</style>'
        f"<h1>{escape(title)}</h1><nav>{links}</nav>{''.join(map(_html, parts))}</html>\n"
    )


def anchor(text: str) -> str:
    """What a heading is linked by."""
    return "".join(one if one.isalnum() else "-" for one in text.lower())


def _html(part: dict[str, Any]) -> str:
    match part:
        case {"kind": "heading", "level": level, "text": text}:
            return f'<h{level} id="{anchor(text)}">{escape(text)}</h{level}>'
        case {"kind": "text", "text": text}:
            return f"<p>{escape(text)}</p>"
        case {"kind": "list", "items": items}:
            return f"<ul>{''.join(f'<li>{escape(item)}</li>' for item in items)}</ul>"
        case {"kind": "figure", "key": key, "caption": caption}:
            name = escape(key)
            return (
                f"<figure><figcaption>{escape(caption)}</figcaption><picture>"
                f'<source srcset="{name}-dark.png" media="(prefers-color-scheme: dark)">'
                f'<img src="{name}.png" alt="{escape(caption)}"></picture></figure>'
            )
        case {"head": head, "rows": rows}:
            names = "".join(f"<th>{escape(name)}</th>" for name in head)
            body = "".join(
                f"<tr>{''.join(f'<td>{escape(shown_cell(cell))}</td>' for cell in row)}</tr>"
                for row in rows
            )
            table = f'<div class="scroll"><table><tr>{names}</tr>{body}</table></div>'
            if len(rows) <= FOLDED:
                return table
            return f"<details><summary>{len(rows)} rows</summary>{table}</details>"
    raise AssertionError(part)
