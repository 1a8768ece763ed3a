"""What simulation says of the cells of a heatmap, in place of the critic's values.

Satisfying cells are dark blue and failing ones light orange: they differ in lightness too, for
those who see no hues. Cells that are not simulated yet are empty. Crosses stand on cells on whose
verdict the critic's ranking is wrong.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from core.decompose import Variable
from core.truth import Truth, misjudged
from studio.page.figures import svg
from studio.page.figures.colors import data_url
from studio.page.figures.heatmap import (
    FLAT,
    LEFT,
    PLOT,
    TOLERANCE,
    TOP,
    WIDTH,
    Cells,
    Drawing,
    height_of,
    map_svg,
)
from studio.theme import MUTED

BARELY, WELL = np.array([67, 130, 185]), np.array([8, 48, 107])
"""Colours of satisfying cells, from robustness 0 to the largest."""

NEARLY, BADLY = np.array([254, 230, 200]), np.array([245, 160, 80])
"""Colours of failing cells, from robustness 0 to the least."""


def truth_svg(truth: Truth, variables: Sequence[Variable], drawing: Drawing) -> str:
    """Draw the verdicts over the variables on the axes."""
    heatmap, height = truth.heatmap, height_of(truth.heatmap)
    if not heatmap.axes:
        return ""
    low, high = robustness_range(truth)
    cells = Cells(
        truth_pixels(truth),
        [_crosses(wrong_cells(truth), height)],
        _legend(low, high, height),
        "robustness of simulated schedules",
    )
    return map_svg(heatmap, variables, replace(drawing, robustness=truth.robustness), cells)


def truth_pixels(truth: Truth) -> np.ndarray:
    """Colours [h, w, 4] of the cells, the largest value of the second variable on top."""
    low, high = robustness_range(truth)
    known = np.nan_to_num(truth.robustness, nan=0.0, neginf=low, posinf=high)
    well, badly = (np.clip(known / end, 0, 1)[..., None] for end in (high, low))
    color = np.where(
        truth.satisfied[..., None],
        BARELY + well * (WELL - BARELY),
        NEARLY + badly * (BADLY - NEARLY),
    )
    opacity = np.where(truth.simulated, 255, 0)[..., None]
    return np.concatenate([color, opacity], -1)[::-1].round().astype(np.uint8)


def robustness_range(truth: Truth) -> tuple[float, float]:
    """The least and the largest robustness, below and above zero [m]."""
    finite = truth.robustness[np.isfinite(truth.robustness)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    return min(low, -1e-3), max(high, 1e-3)


def wrong_cells(truth: Truth) -> np.ndarray:
    """Cells [h, w] that leave time to travel, on whose verdict the critic's ranking is wrong."""
    return misjudged(truth, truth.heatmap.shortfall <= TOLERANCE)


def _crosses(wrong: np.ndarray, height: float) -> str:
    across, up = PLOT / wrong.shape[1], height / wrong.shape[0]
    arm = 0.28 * min(across, up)
    path = "".join(
        f"M{LEFT + (column + 0.5) * across - arm:.1f} {TOP + height - (row + 0.5) * up - arm:.1f}"
        f"l{2 * arm:.1f} {2 * arm:.1f}m0 {-2 * arm:.1f}l{-2 * arm:.1f} {2 * arm:.1f}"
        for row, column in np.argwhere(wrong)
    )
    return (
        f'<g class="tg-wrong" fill="none" pointer-events="none"><path d="{path}" stroke="#fff" '
        f'stroke-width="2.8"/><path d="{path}" stroke="#000" stroke-width="1.3"/></g>'
    )


def _legend(low: float, high: float, height: float) -> list[str]:
    """A bar whose halves are those that satisfy and those that fail, each with its own scale."""
    x, share = LEFT + PLOT + 14, np.linspace(1, 0, 32)[:, None]
    bar = np.concatenate([BARELY + share * (WELL - BARELY), BADLY + share * (NEARLY - BADLY)])
    parts = [
        f'<image x="{x}" y="{TOP}" width="11" height="{height}" preserveAspectRatio="none" '
        'style="cursor:default;image-rendering:auto" '
        f'href="{data_url(bar[:, None].round().astype(np.uint8))}"/>'
    ]
    for place, value in ((0.0, high), (0.5, 0.0), (1.0, low)):
        y = min(max(TOP + place * height, TOP + 4.0), TOP + height - 1.0)
        parts.append(svg.text(x + 15, y + 3.5, f"{value:.2g}", size=10, color=MUTED))
    turn = f'transform="rotate(-90 {WIDTH - 4} {TOP + height / 2})"'
    name = "robustness [m]" if height > FLAT else "[m]"
    title = svg.text(
        WIDTH - 4, TOP + height / 2, name, size=10, anchor="middle", color=MUTED, extra=turn
    )
    return [*parts, title]
