"""The critic over two time variables as an SVG with axes, legend, markers and clickable cells.

With one variable it is a curve (`studio.page.figures.curve`), with none there is no figure. Cells
that leave too little time to travel are hatched and fade to grey: such schedules are hardly
trained on, so the critic is unreliable there.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from core.decompose import Variable
from core.heatmap import Heatmap
from studio.export.marks import TOLERANCE, Mark, color_range
from studio.page.figures import svg
from studio.page.figures.colors import data_url, viridis
from studio.page.figures.readout import cell_data, cell_under_pointer, show_cell
from studio.page.figures.ticks import ticks
from studio.theme import MUTED

WIDTH, LEFT, TOP, BOTTOM, BAR = 372, 44, 8, 38, 66  # [px]
PLOT = WIDTH - LEFT - BAR
TALL, FLAT = 216, 40
GREYED = np.array([222, 226, 230])
FADED = 4.0
"""Shortfall from which a cell is grey [steps]."""

MOST_DOTS = 150
HATCH = (
    '<defs><pattern id="tg-hatch" width="6" height="6" patternUnits="userSpaceOnUse" '
    'patternTransform="rotate(45)"><line x1="0" y1="0" x2="0" y2="6" stroke="#868e96" '
    'stroke-opacity="0.55" stroke-width="1.4"/></pattern></defs>'
)


@dataclass(frozen=True)
class Drawing:
    """What is drawn on top of the heatmap.

    Attributes:
        onpointer: JavaScript for a click on a cell; it may use `column` and `row`, the cell.
        marks: drawn where they lie on the map.
        chains: schedules [C, V] at which the Metropolis-Hastings chains stand.
        reason: says why a cell (row, column) leaves too little time to travel.
        robustness: that of the cells' rollouts [h, w], for the read-out [m].
    """

    onpointer: str = ""
    marks: Sequence[Mark] = ()
    chains: np.ndarray | None = None
    reason: Callable[[int, int], str] | None = None
    robustness: np.ndarray | None = None


@dataclass(frozen=True)
class Cells:
    """How the cells of a map are coloured.

    Attributes:
        pixels: colours [h, w, 3 or 4], the largest value of the second variable on top.
        over: drawn on the cells, below the marks.
        legend: the colour bar.
        label: of the figure, for those who cannot see it.
    """

    pixels: np.ndarray
    over: Sequence[str]
    legend: Sequence[str]
    label: str


def heatmap_svg(heatmap: Heatmap, variables: Sequence[Variable], drawing: Drawing) -> str:
    """Draw the critic's map over the variables that its axes index."""
    if not heatmap.axes:
        return ""
    height = height_of(heatmap)
    legend = _legend(*color_range(heatmap), height)
    cells = Cells(pixels(heatmap), (), legend, "heatmap of the critic")
    return map_svg(heatmap, variables, drawing, cells)


def map_svg(heatmap: Heatmap, variables: Sequence[Variable], drawing: Drawing, cells: Cells) -> str:
    """Draw cells with axes, and what lies on top."""
    height = height_of(heatmap)
    parts = [
        f'<image class="tg-cells" x="{LEFT}" y="{TOP}" width="{PLOT}" height="{height}" '
        f'preserveAspectRatio="none" href="{data_url(cells.pixels)}" '
        f"{handlers(heatmap, variables, drawing)}/>",
        HATCH,
        f'<path class="tg-ruled-out" d="{_ruled_out(heatmap, height)}" '
        'fill="url(#tg-hatch)" pointer-events="none"/>',
        f'<rect x="{LEFT}" y="{TOP}" width="{PLOT}" height="{height}" fill="none" '
        'style="stroke:var(--mantine-color-default-border);pointer-events:none"/>',
        *horizontal_axis(heatmap, variables, height),
        *_vertical(heatmap, variables, height),
        *cells.legend,
        *cells.over,
        _dots(heatmap, drawing.chains, height),
        *(_mark(heatmap, mark, height) for mark in drawing.marks),
    ]
    drawn = svg.document(WIDTH, TOP + height + BOTTOM, parts, cells.label)
    return f'<div class="tg-heat">{drawn}</div>'


def height_of(heatmap: Heatmap) -> int:
    """Height of the plot [px]."""
    return TALL if len(heatmap.axes) > 1 else FLAT


def handlers(heatmap: Heatmap, variables: Sequence[Variable], drawing: Drawing) -> str:
    """Attributes of the element over the cells: their data and pointer handlers."""
    names = [variables[axis].name for axis in heatmap.axes]
    cell = cell_under_pointer(heatmap.first.size, heatmap.second.size)
    click = svg.escape(cell + drawing.onpointer)
    data = cell_data(heatmap, names, TOLERANCE, drawing.reason, drawing.robustness)
    return f'{data} onpointermove="{svg.escape(cell + show_cell())}" onpointerdown="{click}"'


def pixels(heatmap: Heatmap) -> np.ndarray:
    """Colours [h, w, 3] of the cells, the largest value of the second variable on top."""
    low, high = color_range(heatmap)
    color = viridis((heatmap.values - low) / (high - low)).astype(float)
    fade = np.clip(heatmap.shortfall / FADED, 0, 1)[..., None]
    return ((1 - fade) * color + fade * GREYED)[::-1].round().astype(np.uint8)


def place(values: np.ndarray, value: float) -> float:
    """Position on the axis, in [0, 1], of the centre of a value's cell."""
    return float((np.interp(value, values, np.arange(values.size)) + 0.5) / values.size)


def horizontal_axis(heatmap: Heatmap, variables: Sequence[Variable], height: float) -> list[str]:
    """The first variable below a plot of a height [px]."""
    values, base = heatmap.first, TOP + height
    parts = []
    for tick in ticks(float(values[0]), float(values[-1]), 7):
        x = LEFT + PLOT * place(values, tick)
        parts.append(_line(x, base, x, base + 4))
        parts.append(svg.text(x, base + 15, f"{tick:g}", size=10, anchor="middle", color=MUTED))
    title = f"{variables[heatmap.axes[0]].name}  [steps]"
    parts.append(svg.text(LEFT + PLOT / 2, base + 31, title, anchor="middle", weight=500))
    return parts


def _vertical(heatmap: Heatmap, variables: Sequence[Variable], height: float) -> list[str]:
    if len(heatmap.axes) < 2:
        return []
    values, parts = heatmap.second, []
    for tick in ticks(float(values[0]), float(values[-1]), 6):
        y = TOP + height * (1 - place(values, tick))
        parts.append(_line(LEFT - 4, y, LEFT, y))
        parts.append(svg.text(LEFT - 7, y + 3.5, f"{tick:g}", size=10, anchor="end", color=MUTED))
    title = f"{variables[heatmap.axes[1]].name}  [steps]"
    middle = TOP + height / 2
    turn = f'transform="rotate(-90 12 {middle})"'
    parts.append(svg.text(12, middle, title, anchor="middle", weight=500, extra=turn))
    return parts


def _legend(low: float, high: float, height: float) -> list[str]:
    x, bar = LEFT + PLOT + 14, viridis(np.linspace(1, 0, 64))[:, None]
    parts = [
        f'<image x="{x}" y="{TOP}" width="11" height="{height}" preserveAspectRatio="none" '
        f'style="cursor:default;image-rendering:auto" href="{data_url(bar)}"/>'
    ]
    for tick in ticks(low, high, 6 if height > FLAT else 3):
        y = TOP + height * (high - tick) / (high - low)
        parts.append(_line(x + 11, y, x + 14, y))
        parts.append(svg.text(x + 17, y + 3.5, f"{tick:g}", size=10, color=MUTED))
    turn = f'transform="rotate(-90 {WIDTH - 4} {TOP + height / 2})"'
    title = svg.text(
        WIDTH - 4, TOP + height / 2, "value", size=10, anchor="middle", color=MUTED, extra=turn
    )
    return [*parts, title]


def _ruled_out(heatmap: Heatmap, height: float) -> str:
    """Path around the cells that leave too little time, a rectangle for each run in a row."""
    out = heatmap.shortfall > TOLERANCE
    cell = (PLOT / heatmap.first.size, height / heatmap.second.size)
    path = []
    for row, bad in enumerate(out):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], bad, [False]])))
        top = TOP + height - (row + 1) * cell[1]
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            x, width = LEFT + start * cell[0], (stop - start) * cell[0]
            path.append(f"M{x:.1f} {top:.1f}h{width:.1f}v{cell[1]:.1f}h{-width:.1f}z")
    return "".join(path)


def _dots(heatmap: Heatmap, schedules: np.ndarray | None, height: float) -> str:
    """A dot for each different cell in which schedules lie."""
    if schedules is None or len(heatmap.axes) < 2:
        return ""
    first, second = heatmap.axes
    points = np.unique(np.asarray(schedules)[:, [first, second]], axis=0)[:MOST_DOTS]
    circles = "".join(
        f'<circle cx="{LEFT + PLOT * place(heatmap.first, x):.1f}" '
        f'cy="{TOP + height * (1 - place(heatmap.second, y)):.1f}" r="1.5"/>'
        for x, y in points
    )
    return (
        '<g class="tg-chains" fill="#fff" stroke="#000" stroke-opacity="0.55" '
        f'stroke-width="0.8" pointer-events="none">{circles}</g>'
    )


def _mark(heatmap: Heatmap, mark: Mark, height: float) -> str:
    x = LEFT + PLOT * place(heatmap.first, mark.schedule[heatmap.axes[0]])
    y = TOP + height / 2
    if len(heatmap.axes) > 1:
        y = TOP + height * (1 - place(heatmap.second, mark.schedule[heatmap.axes[1]]))
    return (
        f'<g style="pointer-events:none"><circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="none" '
        f'stroke="#000" stroke-opacity="0.45" stroke-width="4"/>'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="none" stroke="{mark.color}" '
        f'stroke-width="2.2"><title>{svg.escape(mark.label)}</title></circle></g>'
    )


def _line(x1: float, y1: float, x2: float, y2: float) -> str:
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" '
        'stroke="var(--mantine-color-default-border)"/>'
    )
