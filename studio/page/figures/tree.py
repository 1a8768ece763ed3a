"""The decomposition as a picture, similar to the paper's Fig. 2.

An outline from left to right: operator nodes, time variables with their domains on the edges,
and tasks as leaves, coloured by their kind. Sibling invariants over one window share a leaf.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from core.decompose import Decomposition, Kind, Subtask, TreeNode
from core.stl import to_math
from studio.page.figures import svg
from studio.theme import KIND_COLOR, KIND_FILL, MUTED, TIME, themed

SIZE = 11  # of the font [px]
ROW, BOX, INDENT, MARGIN = 26, 19, 16, 4  # [px]
LABEL = 'class="tg-leaf-name"'
MOST_NAMES = 3
LEAST_WIDTH = 340  # [px]


@dataclass(frozen=True)
class _Row:
    """A line of the outline."""

    depth: int
    parent: int
    edge: str
    label: str
    hint: str
    kind: Kind | None
    tasks: tuple[int, ...] = ()


def tree_svg(decomposition: Decomposition, handlers: str = "") -> str:
    """Draw the tree.

    Args:
        decomposition: of the formula.
        handlers: attributes for the leaves, which carry their tasks as `data-tasks="0,1"`.
    """
    rows = list(_rows(decomposition, decomposition.tree, 0, -1, [0]))
    parts: list[str] = []
    width = float(LEAST_WIDTH)
    for number, row in enumerate(rows):
        if row.parent >= 0:
            parts.append(_elbow(row, number))
        drawn, right = _draw(row, number, handlers)
        parts.append(drawn)
        width = max(width, right + MARGIN)
    return svg.document(width, len(rows) * ROW + MARGIN, parts, "decomposition tree")


def abbreviations(decomposition: Decomposition) -> list[tuple[str, str]]:
    """Names of subformulas in the tree's labels, and what they stand for."""
    return [(_greek(name), to_math(formula)) for name, formula in decomposition.names[1:]]


def joined(names: list[str]) -> str:
    """`a, b, c`; if there are many, the first two and the last."""
    if len(names) <= MOST_NAMES:
        return ", ".join(names)
    return f"{names[0]}, {names[1]}, …, {names[-1]}"


def _rows(
    decomposition: Decomposition, node: TreeNode, depth: int, parent: int, count: list[int]
) -> Iterator[_Row]:
    """Rows of a node and what is below it; `count` holds the number of rows so far."""
    number = count[0]
    yield _row(decomposition, [node], depth, parent)
    count[0] += 1
    for group in _groups(decomposition, node.children):
        if len(group) == 1:
            yield from _rows(decomposition, group[0], depth + 1, number, count)
        else:
            yield _row(decomposition, group, depth + 1, number)
            count[0] += 1


def _groups(decomposition: Decomposition, children) -> list[list[TreeNode]]:
    """Children; invariants with equal windows and guards are grouped where the first stands."""
    groups: dict[object, list[TreeNode]] = {}
    for position, child in enumerate(children):
        key: object = position
        if child.task is not None and child.variable is None and not child.children:
            task = decomposition.tasks[child.task]
            if task.kind is Kind.INVARIANT:
                key = (task.start, task.end, task.guards)
        groups.setdefault(key, []).append(child)
    return list(groups.values())


def _row(decomposition: Decomposition, group: list[TreeNode], depth: int, parent: int) -> _Row:
    node = group[0]
    edge = _edge(decomposition, node)
    hint = "\n".join(to_math(each.formula) for each in group)
    if node.task is None:
        return _Row(depth, parent, edge, _greek(node.label) or "true", hint, None)
    indices = tuple(each.task for each in group if each.task is not None)
    tasks = [decomposition.tasks[index] for index in indices]
    label = _task_label(decomposition, tasks)
    return _Row(depth, parent, edge, label, hint, tasks[0].kind, indices)


def leaves(decomposition: Decomposition) -> list[tuple[int, ...]]:
    """Tasks of each leaf that the tree shows."""
    rows = _rows(decomposition, decomposition.tree, 0, -1, [0])
    return [row.tasks for row in rows if row.tasks]


def leaf_id(tasks: tuple[int, ...]) -> str:
    """What a leaf carries as `data-tasks`."""
    return ",".join(map(str, tasks))


def _task_label(decomposition: Decomposition, tasks: list[Subtask]) -> str:
    first, variables = tasks[0], decomposition.variables
    what = joined([to_math(task.predicate) for task in tasks])
    start, end = _tight(first.start.text(variables)), _tight(first.end.text(variables))
    if first.kind is Kind.REACH:
        return f"Reach({what}, {start})"
    return f"Inv({what}, [{start}, {end}])"


def _edge(decomposition: Decomposition, node: TreeNode) -> str:
    if node.variable is None:
        return ""
    variable = decomposition.variables[node.variable]
    if node.choice is not None:
        return f"{variable.name} = {node.choice}"
    return f"{variable.name} ∈ [{variable.low}, {variable.high}]"


def _draw(row: _Row, number: int, handlers: str) -> tuple[str, float]:
    """The row's edge label and box, and where the box ends [px]."""
    x, top = MARGIN + row.depth * INDENT, number * ROW + MARGIN
    base = top + BOX / 2 + SIZE * 0.36
    leaf = f' class="tg-leaf" data-tasks="{leaf_id(row.tasks)}" {handlers}' if row.tasks else ""
    parts = [f"<g{leaf}><title>{svg.escape(row.hint)}</title>"]
    if row.edge:
        parts.append(
            svg.text(x + 2, base, row.edge, size=SIZE, color=themed("time", TIME), mono=True)
        )
        x += svg.mono_width(row.edge, SIZE) + 9
    width = svg.mono_width(row.label, SIZE) + 12
    fill, ink = "var(--mantine-color-default-hover)", MUTED
    if row.kind is not None:
        kind = row.kind.name.lower()
        fill = themed(f"{kind}-fill", KIND_FILL[row.kind])
        ink = themed(f"{kind}-ink", KIND_COLOR[row.kind])
    parts.append(
        f'<rect x="{x:.1f}" y="{top}" width="{width:.1f}" height="{BOX}" rx="4" '
        f'style="fill:{fill};stroke:{ink}" stroke-opacity="0.55"/>'
    )
    color = "var(--mantine-color-text)" if row.kind is None else ink
    label = svg.text(x + 6, base, row.label, size=SIZE, color=color, mono=True, extra=LABEL)
    parts.append(f"{label}</g>")
    return "".join(parts), x + width


def _elbow(row: _Row, number: int) -> str:
    x = MARGIN + (row.depth - 1) * INDENT + 7
    top, middle = row.parent * ROW + MARGIN + BOX, number * ROW + MARGIN + BOX / 2
    return (
        f'<path d="M{x} {top} V{middle - 4:.1f} q0 4 4 4 H{x + INDENT - 8}" fill="none" '
        'stroke="var(--mantine-color-default-border)"/>'
    )


def _tight(text: str) -> str:
    return text.replace(" ", "")


def _greek(label: str) -> str:
    """Write phi0 as φ₀ (short names never equal a region's name)."""
    digits = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
    return re.sub(r"\bphi(\d*)\b", lambda found: "φ" + found[1].translate(digits), label)
