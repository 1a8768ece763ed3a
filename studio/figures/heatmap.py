"""The critic over two time variables as an SVG with axes, legend, markers and clickable cells.

With one variable the map is a strip, with none there is none. Cells fade to grey as their legs
get too short to travel: such schedules are hardly trained on, so the critic's word on them means
little.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from core.decompose import Variable
from core.heatmap import Heatmap
from studio.figures import svg
from studio.figures.colors import data_url, viridis
from studio.figures.ticks import ticks
from studio.theme import MUTED

WIDTH, LEFT, TOP, BOTTOM, BAR = 372, 44, 8, 38, 66  # [px]
PLOT = WIDTH - LEFT - BAR
TALL, FLAT = 216, 40
GREYED = np.array([222, 226, 230])
TOLERANCE, FADED = 1.0, 4.0
"""Shortfall up to which a schedule still counts, and from which it is grey [steps]."""


@dataclass(frozen=True)
class Mark:
    """A schedule pointed out on the map."""

    schedule: Sequence[int]
    color: str
    label: str


def heatmap_svg(
    heatmap: Heatmap, variables: Sequence[Variable], marks: Sequence[Mark], onpointer: str
) -> str:
    """Draw the map.

    Args:
        heatmap: the critic's values.
        variables: of the decomposition, which the axes index.
        marks: drawn where they lie on the map.
        onpointer: JavaScript for a click on a cell; it may use `column` and `row`, the cell.
    """
    if not heatmap.axes:
        return ""
    height = TALL if len(heatmap.axes) > 1 else FLAT
    low, high = color_range(heatmap)
    handler = (
        "const box=this.getBoundingClientRect(),"
        f"cell=(f,n)=>Math.min(n-1,Math.max(0,Math.floor(f*n))),"
        f"column=cell((event.clientX-box.left)/box.width,{heatmap.first.size}),"
        f"row=cell((box.bottom-event.clientY)/box.height,{heatmap.second.size});{onpointer}"
    )
    parts = [
        f'<image class="tg-cells" x="{LEFT}" y="{TOP}" width="{PLOT}" height="{height}" '
        f'preserveAspectRatio="none" href="{data_url(pixels(heatmap))}" '
        f'onpointerdown="{svg.escape(handler)}"/>',
        f'<rect x="{LEFT}" y="{TOP}" width="{PLOT}" height="{height}" fill="none" '
        'style="stroke:var(--mantine-color-gray-5);pointer-events:none"/>',
        *_horizontal(heatmap, variables, height),
        *_vertical(heatmap, variables, height),
        *_legend(low, high, height),
        *(_mark(heatmap, mark, height) for mark in marks),
    ]
    drawn = svg.document(WIDTH, TOP + height + BOTTOM, parts, "heatmap of the critic")
    return f'<div class="tg-heat">{drawn}</div>'


def color_range(heatmap: Heatmap) -> tuple[float, float]:
    """Values at the ends of the colour bar: those of the schedules that leave time to travel."""
    sound = heatmap.values[(heatmap.shortfall <= TOLERANCE) & np.isfinite(heatmap.values)]
    if sound.size == 0:
        sound = heatmap.values[np.isfinite(heatmap.values)]
    if sound.size == 0:
        return 0.0, 1.0
    low, high = float(sound.min()), float(sound.max())
    return (low, high) if high - low > 1e-6 else (low - 0.5, high + 0.5)


def pixels(heatmap: Heatmap) -> np.ndarray:
    """Colours [h, w, 3] of the cells, the largest value of the second variable on top."""
    low, high = color_range(heatmap)
    color = viridis((heatmap.values - low) / (high - low)).astype(float)
    fade = np.clip(heatmap.shortfall / FADED, 0, 1)[..., None]
    return ((1 - fade) * color + fade * GREYED)[::-1].round().astype(np.uint8)


def _place(values: np.ndarray, value: float) -> float:
    """Share of the axis [0, 1] at which a value's cell has its centre."""
    return float((np.interp(value, values, np.arange(values.size)) + 0.5) / values.size)


def _horizontal(heatmap: Heatmap, variables: Sequence[Variable], height: float) -> list[str]:
    values, base = heatmap.first, TOP + height
    parts = []
    for tick in ticks(float(values[0]), float(values[-1]), 7):
        x = LEFT + PLOT * _place(values, tick)
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
        y = TOP + height * (1 - _place(values, tick))
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


def _mark(heatmap: Heatmap, mark: Mark, height: float) -> str:
    x = LEFT + PLOT * _place(heatmap.first, mark.schedule[heatmap.axes[0]])
    y = TOP + height / 2
    if len(heatmap.axes) > 1:
        y = TOP + height * (1 - _place(heatmap.second, mark.schedule[heatmap.axes[1]]))
    return (
        f'<g style="pointer-events:none"><circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="none" '
        f'stroke="#000" stroke-opacity="0.45" stroke-width="4"/>'
        f'<circle cx="{x:.1f}" cy="{y:.1f}" r="6" fill="none" stroke="{mark.color}" '
        f'stroke-width="2.2"><title>{svg.escape(mark.label)}</title></circle></g>'
    )


def _line(x1: float, y1: float, x2: float, y2: float) -> str:
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" '
        'stroke="var(--mantine-color-gray-5)"/>'
    )
