"""Beside the critic's map: the switch to what simulation says, and that in one line."""

import numpy as np

from core.truth import Truth, nothing_simulated
from studio.page.analyst import Analyst
from studio.page.figures.svg import escape
from studio.page.figures.truth import BADLY, WELL, wrong_cells
from studio.page.picture import Picture
from studio.page.server.clicks import ClickField

CRITIC, SIMULATED = "critic", "simulated"
LABELS = {CRITIC: "Critic", SIMULATED: "Simulated"}


def switch_html(clicks: ClickField, *, simulating: bool) -> str:
    """Two buttons, of which one is pressed."""
    buttons = "".join(
        f'<button type="button" aria-pressed="{str((value == SIMULATED) == simulating).lower()}" '
        f'onclick="{escape(clicks.script(repr(value)))}">{label}</button>'
        for value, label in LABELS.items()
    )
    return f'<div class="tg"><div class="tg-chips">{buttons}</div></div>'


def press(analyst: Analyst, value: str) -> None:
    """Act on a button; unknown values are ignored."""
    if value in LABELS:
        analyst.simulate(value == SIMULATED)


def truth_of(analyst: Analyst, picture: Picture) -> Truth | None:
    """What is known of a picture's cells so far; None if the critic's values are wanted."""
    if not analyst.simulating or not picture.heatmap.axes:
        return None
    found = analyst.simulated
    if found is None or found.picture is not picture:
        return nothing_simulated(picture.heatmap)
    return found.truth


def truth_line(truth: Truth) -> str:
    """How many schedules satisfy the formula, and how well the critic ranks them."""
    simulated, cells = int(truth.simulated.sum()), truth.robustness.size
    if simulated == 0:
        return f"Simulating {cells} schedules…"
    so_far = "" if simulated == cells else f" ({cells - simulated} to come)"
    line = f"Simulated: {int(truth.satisfied.sum())} of {simulated}{so_far} schedules satisfy"
    line += " the formula"
    if np.isfinite(truth.correlation):
        line += f"; rank correlation with the critic {truth.correlation:.2f}"
    return line + "."


def truth_keys(truth: Truth) -> list[str]:
    """What the colours and the crosses mean."""
    keys = [f"{_square(WELL)} satisfied", f"{_square(BADLY)} fails"]
    wrong = int(wrong_cells(truth).sum())
    if wrong:
        keys.append(f"✕ the critic ranks it on the wrong side ({wrong})")
    return keys


def _square(color: np.ndarray) -> str:
    red, green, blue = color.tolist()
    return f'<span style="color:rgb({red},{green},{blue})">■</span>'
