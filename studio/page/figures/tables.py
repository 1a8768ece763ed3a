"""The tasks of a decomposition as an HTML table; invariants over one window share a row."""

from collections.abc import Iterator

from core.decompose import Decomposition, Kind, TaskRow, task_name, task_rows
from core.stl import to_math
from studio.page.figures.svg import escape
from studio.page.figures.tree import abbreviations
from studio.theme import KIND_COLOR


def task_table(decomposition: Decomposition) -> str:
    """Task, predicate, start and end; and its branches, if there are any."""
    rows = list(_rows(decomposition))
    columns = 5 if any(row[4] for row in rows) else 4
    head = "".join(f"<th>{name}</th>" for name in ("Task", "Holds", "From", "To", "If")[:columns])
    body = "".join(
        "<tr>" + "".join(f"<td>{cell}</td>" for cell in row[:columns]) + "</tr>" for row in rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _tight(row: TaskRow) -> tuple[str, str]:
    return row.start.replace(" ", ""), row.end.replace(" ", "")


def abbreviation_list(decomposition: Decomposition) -> str:
    """What each φ in the tree stands for."""
    lines = [
        f'<div><span class="tg-mono">{escape(name)}</span> = {escape(formula)}</div>'
        for name, formula in abbreviations(decomposition)
    ]
    return f'<div class="tg-dim">{"".join(lines)}</div>' if lines else ""


def _rows(decomposition: Decomposition) -> Iterator[tuple[str, ...]]:
    groups: dict[object, list[int]] = {}
    for index, task in enumerate(decomposition.tasks):
        shared = task.kind is Kind.INVARIANT
        key = (task.start, task.end, task.guards) if shared else index
        groups.setdefault(key, []).append(index)
    texts = task_rows(decomposition)
    for group in groups.values():
        kind = decomposition.tasks[group[0]].kind
        name = task_name(decomposition, group[0])
        if len(group) > 1:
            name = f"Invariants ({len(group)})"
        dot = f'<span class="tg-dot" style="background:{KIND_COLOR[kind]}"></span>'
        holds = ", ".join(to_math(decomposition.tasks[index].predicate) for index in group)
        row = texts[group[0]]
        yield (
            f'<span style="white-space:nowrap">{dot}{escape(name)}</span>',
            f'<span class="tg-mono">{escape(holds)}</span>',
            *(f'<span class="tg-mono">{escape(cell)}</span>' for cell in _tight(row)),
            escape(row.when),
        )
