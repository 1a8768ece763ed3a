"""The critic over a single time variable: a curve, read and clicked like a heatmap."""

from collections.abc import Sequence

import numpy as np

from core.decompose import Variable
from core.heatmap import Heatmap
from studio.page.figures import svg
from studio.page.figures.heatmap import (
    BAR,
    BOTTOM,
    HATCH,
    LEFT,
    TOLERANCE,
    TOP,
    WIDTH,
    Drawing,
    handlers,
    horizontal_axis,
    place,
)
from studio.page.figures.ticks import ticks
from studio.theme import MUTED

HEIGHT, PLOT = 150, WIDTH - LEFT - BAR  # [px]
INK = "#1e6091"


def curve_svg(heatmap: Heatmap, variables: Sequence[Variable], drawing: Drawing) -> str:
    """Draw the critic's value over the only variable on the axes."""
    values = np.nan_to_num(heatmap.values[0])
    low, high = float(values.min()), float(values.max())
    margin = 0.08 * (high - low) + 1e-6
    low, high = low - margin, high + margin

    def at(column: int) -> tuple[float, float]:
        x = LEFT + PLOT * (column + 0.5) / values.size
        return x, TOP + HEIGHT * (high - float(values[column])) / (high - low)

    points = " ".join("{:.1f},{:.1f}".format(*at(column)) for column in range(values.size))
    parts = [
        HATCH,
        f'<path class="tg-ruled-out" d="{_ruled_out(heatmap)}" fill="url(#tg-hatch)"/>',
        *_vertical(low, high),
        f'<polyline points="{points}" fill="none" stroke="{INK}" stroke-width="2.2"/>',
        *horizontal_axis(heatmap, variables, HEIGHT),
    ]
    for mark in drawing.marks:
        column = round(place(heatmap.first, mark.schedule[heatmap.axes[0]]) * values.size - 0.5)
        x, y = at(column)
        parts.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="5.5" fill="{mark.color}" stroke="#495057" '
            f'stroke-width="1.5"><title>{svg.escape(mark.label)}</title></circle>'
        )
    parts.append(
        f'<rect class="tg-cells" x="{LEFT}" y="{TOP}" width="{PLOT}" height="{HEIGHT}" '
        'fill="transparent" style="cursor:crosshair;stroke:var(--mantine-color-default-border)" '
        f"{handlers(heatmap, variables, drawing)}/>"
    )
    drawn = svg.document(WIDTH, TOP + HEIGHT + BOTTOM, parts, "the critic over a time variable")
    return f'<div class="tg-heat">{drawn}</div>'


def _ruled_out(heatmap: Heatmap) -> str:
    width = PLOT / heatmap.first.size
    return "".join(
        f"M{LEFT + column * width:.1f} {TOP}h{width:.1f}v{HEIGHT}h{-width:.1f}z"
        for column in np.flatnonzero(heatmap.shortfall[0] > TOLERANCE)
    )


def _vertical(low: float, high: float) -> list[str]:
    parts = []
    for tick in ticks(low, high, 5):
        y = TOP + HEIGHT * (high - tick) / (high - low)
        parts.append(
            f'<line x1="{LEFT}" y1="{y:.1f}" x2="{LEFT + PLOT}" y2="{y:.1f}" '
            'stroke="var(--mantine-color-default-border)"/>'
        )
        parts.append(svg.text(LEFT - 7, y + 3.5, f"{tick:g}", size=10, anchor="end", color=MUTED))
    turn = f'transform="rotate(-90 12 {TOP + HEIGHT / 2})"'
    title = svg.text(
        12, TOP + HEIGHT / 2, "value", size=10, anchor="middle", color=MUTED, extra=turn
    )
    return [*parts, title]
