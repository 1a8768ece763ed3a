"""Exported pictures: the critic's heatmap and the decomposition tree as PNG files in memory.

Drawn by matplotlib without pyplot and without its interpretation of `$`: names and formulas are
text. The page shows SVG (`studio.page.figures`); browsers, not this program, can turn that into
pixels.
"""

import io
import textwrap
from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Patch
from matplotlib.patheffects import withStroke

from core.decompose import Decomposition, TreeNode, edge_text
from core.errors import UserError
from core.heatmap import Heatmap
from core.stl import to_text
from studio.export.marks import Mark, color_range
from studio.theme import KIND_COLOR, KIND_FILL, MONO_WIDTH, TIME

DPI = 160
GREY = "#8a8f98"
LONGEST_LABEL = 140  # characters
MOST_ROWS = 300
ROW, LINE, INDENT, FONT, MARGIN = 22.0, 14.0, 20.0, 9.0, 10.0  # [pt]


class PictureError(UserError):
    """A picture that cannot be drawn."""


def heatmap_png(
    heatmap: Heatmap,
    decomposition: Decomposition,
    *,
    title: str,
    marks: Sequence[Mark] = (),
    chains: np.ndarray | None = None,
) -> bytes:
    """Draw the critic over two time variables, or its curve over one.

    Args:
        heatmap: the critic's values.
        decomposition: the task's, for the names of the axes.
        title: the line above.
        marks: schedules that are marked and named in the legend.
        chains: [N, V] schedules of the Markov chains, drawn as dots.

    Raises:
        PictureError: the formula has no time variables.
    """
    if not heatmap.axes:
        raise PictureError("The formula has no time variables, so there is no heatmap to export.")
    figure = Figure(figsize=(7.2, 5.4 if len(heatmap.axes) > 1 else 3.6), layout="constrained")
    axes = figure.subplots()
    draw = _map if len(heatmap.axes) > 1 else _curve
    legend = draw(figure, axes, heatmap)
    _label_axes(axes, heatmap, decomposition)
    axes.set_title(_shortened(title, 90), fontsize=10, parse_math=False)
    if chains is not None and len(chains):
        points = [_place(heatmap, chain) for chain in np.asarray(chains)]
        legend.append(
            axes.plot(*zip(*points, strict=True), ".", color="white", ms=4, mec="black")[0]
        )
        legend[-1].set_label("chains")
    legend += [_draw_mark(axes, heatmap, mark) for mark in marks]
    if legend:
        shown = figure.legend(handles=legend, fontsize=8, loc="outside lower center", ncols=4)
        for entry in shown.get_texts():
            entry.set_parse_math(False)
    return _png(figure, title, to_text(decomposition.formula))


def tree_png(decomposition: Decomposition, *, title: str) -> bytes:
    """Draw the decomposition as an outline: time variables on the edges, tasks coloured by kind.

    Raises:
        PictureError: a tree too large for a picture.
    """
    rows = list(_outline(decomposition.tree, 0, -1, [0]))
    if len(rows) > MOST_ROWS:
        raise PictureError(
            f"The tree has {len(rows)} nodes; a picture can show at most {MOST_ROWS} nodes."
        )
    names = [line for name, each in decomposition.names for line in _wrapped(name, to_text(each))]
    width = max(_row_width(decomposition, node, depth) for node, depth, _ in rows)
    width = max(width, 240.0, *map(_text_width, names)) + 2 * MARGIN
    height = (len(rows) + 1) * ROW + len(names) * LINE + 3 * MARGIN
    figure = Figure(figsize=(width / 72, height / 72))
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.set_axis_off()
    _write(axes, MARGIN, MARGIN + ROW / 2, _shortened(title, int(width / FONT * 1.6)), "black")
    for number, (node, depth, parent) in enumerate(rows):
        if parent >= 0:
            _draw_elbow(axes, depth, _middle(parent), _middle(number))
        _draw_node(axes, decomposition, node, depth, _middle(number))
    for number, text in enumerate(names):
        _write(axes, MARGIN, _middle(len(rows)) + number * LINE, text, "#495057")
    return _png(figure, title, to_text(decomposition.formula))


def _map(figure: Figure, axes: Axes, heatmap: Heatmap) -> list:
    low, high = color_range(heatmap)
    edges = _edges(heatmap.first), _edges(heatmap.second)
    mesh = axes.pcolormesh(*edges, heatmap.values, cmap="viridis", vmin=low, vmax=high)
    figure.colorbar(mesh, ax=axes, label="value of the critic [reward]")
    short = heatmap.shortfall > 0
    if not short.any():
        return []
    covered = np.ma.masked_where(~short, short)
    axes.pcolormesh(*edges, covered, cmap="Greys_r", alpha=0.6, vmin=0)
    clear = ListedColormap([(0.0, 0.0, 0.0, 0.0)])
    axes.pcolor(*edges, covered, cmap=clear, hatch="////", edgecolor=GREY, linewidth=0)
    return [_short_label()]


def _curve(figure: Figure, axes: Axes, heatmap: Heatmap) -> list:
    del figure
    axes.plot(heatmap.first, heatmap.values[0], color="#1e6091")
    axes.set_ylabel("value of the critic [reward]")
    axes.grid(alpha=0.3)
    edges = _edges(heatmap.first)
    short = np.flatnonzero(heatmap.shortfall[0] > 0)
    for column in short:
        axes.axvspan(
            edges[column], edges[column + 1], facecolor="0.92", hatch="////", edgecolor=GREY
        )
    return [_short_label()] if short.size else []


def _short_label() -> Patch:
    return Patch(facecolor="0.92", edgecolor=GREY, hatch="////", label="too little time to travel")


def _edges(values: np.ndarray) -> np.ndarray:
    """Borders of the cells around increasing values."""
    values = np.asarray(values, float)
    if values.size == 1:
        return values[0] + np.array([-0.5, 0.5])
    middle = (values[1:] + values[:-1]) / 2
    return np.concatenate([[2 * values[0] - middle[0]], middle, [2 * values[-1] - middle[-1]]])


def _label_axes(axes: Axes, heatmap: Heatmap, decomposition: Decomposition) -> None:
    names = [variable.name for variable in decomposition.variables]
    fixed = [
        f"{name} = {int(heatmap.schedule[index])}"
        for index, name in enumerate(names)
        if index not in heatmap.axes
    ]
    rest = f"   (with {', '.join(fixed)})" if fixed else ""
    axes.set_xlabel(f"{names[heatmap.axes[0]]} [steps]{rest}")
    if len(heatmap.axes) > 1:
        axes.set_ylabel(f"{names[heatmap.axes[1]]} [steps]")


def _place(heatmap: Heatmap, schedule: Sequence[int]) -> tuple[float, float]:
    """Coordinates of a schedule in the picture."""
    x = float(schedule[heatmap.axes[0]])
    if len(heatmap.axes) > 1:
        return x, float(schedule[heatmap.axes[1]])
    return x, float(np.interp(x, heatmap.first, heatmap.values[0]))


def _draw_mark(axes: Axes, heatmap: Heatmap, mark: Mark):
    x, y = _place(heatmap, mark.schedule)
    style = {"marker": "o", "ms": 10, "mfc": "none", "mew": 1.8, "ls": "none"}
    halo = [withStroke(linewidth=3.6, foreground="#00000099")]
    label = _shortened(mark.label, 60)
    return axes.plot([x], [y], color=mark.color, label=label, path_effects=halo, **style)[0]


def _outline(
    node: TreeNode, depth: int, parent: int, count: list[int]
) -> Iterator[tuple[TreeNode, int, int]]:
    """Nodes with their depth and the row of their parent; `count` holds the rows so far."""
    number = count[0]
    yield node, depth, parent
    count[0] += 1
    for child in node.children:
        yield from _outline(child, depth + 1, number, count)


def _row_width(decomposition: Decomposition, node: TreeNode, depth: int) -> float:
    edge = edge_text(node, decomposition.variables)
    return depth * INDENT + _text_width(edge) + (8 if edge else 0) + _text_width(_label(node)) + 12


def _draw_node(
    axes: Axes, decomposition: Decomposition, node: TreeNode, depth: int, middle: float
) -> None:
    x, edge = MARGIN + depth * INDENT, edge_text(node, decomposition.variables)
    if edge:
        _write(axes, x, middle, edge, TIME)
        x += _text_width(edge) + 8
    kind = None if node.task is None else decomposition.tasks[node.task].kind
    fill, ink = ("#f1f3f5", "#495057") if kind is None else (KIND_FILL[kind], KIND_COLOR[kind])
    width = _text_width(_label(node)) + 12
    box = FancyBboxPatch((x + 3, middle - 5), width - 6, 10, "round,pad=3", fc=fill, ec=ink, lw=0.6)
    axes.add_patch(box)
    _write(axes, x + 6, middle, _label(node), ink)


def _draw_elbow(axes: Axes, depth: int, above: float, middle: float) -> None:
    x = MARGIN + (depth - 1) * INDENT + 8
    axes.plot([x, x, x + INDENT - 9], [above + 8, middle, middle], color="#ced4da", lw=0.9)


def _write(axes: Axes, x: float, y: float, text: str, color: str) -> None:
    axes.text(
        x, y, text, color=color, fontsize=FONT, family="DejaVu Sans Mono", va="center_baseline",
        parse_math=False,
    )  # fmt: skip


def _wrapped(name: str, text: str) -> list[str]:
    first, rest = f"{name} = ", " " * (len(name) + 3)
    return textwrap.wrap(text, 90, initial_indent=first, subsequent_indent=rest, max_lines=20)


def _middle(row: int) -> float:
    return MARGIN + (row + 1.5) * ROW


def _label(node: TreeNode) -> str:
    return _shortened(node.label or "true", LONGEST_LABEL)


def _text_width(text: str) -> float:
    return len(text) * FONT * MONO_WIDTH


def _shortened(text: str, longest: int) -> str:
    text = " ".join(text.split())
    return text if len(text) <= longest else text[: longest - 1] + "…"


def _png(figure: Figure, title: str, formula: str) -> bytes:
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=DPI, metadata={"Title": title, "Description": formula})
    return file.getvalue()
