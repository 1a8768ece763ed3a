"""The monitor table: a row for each subformula, a column for each step, coloured by robustness.

Green: holds, red: fails, stronger for larger robustness; faint where the subformula cannot affect
the verdict, grey where the rollout is too short to decide it.
"""

import numpy as np

from core.monitor import MonitorRow
from core.stl import to_math
from studio.page.figures import svg
from studio.page.figures.colors import data_url
from studio.page.figures.playhead import playhead
from studio.page.figures.ticks import ticks
from studio.runs.recording import Recording
from studio.theme import BAD, MUTED

WIDTH, LEFT, RIGHT, ROW, GAP = 560, 206, 46, 15, 2  # [px]
PLOT = WIDTH - LEFT - RIGHT
INDENT, SIZE = 9, 10.5  # [px]
GREEN, RED, PALE, UNDECIDED = (43, 138, 62), (201, 42, 42), (255, 255, 255), (233, 236, 239)
FULL = 1.0
"""Robustness at which a colour is near full strength [m]."""
LEAST, FAINT = 0.35, 0.22
"""Strength of a colour at robustness 0, and its factor where the verdict is not affected."""


def monitor_html(recording: Recording, onpointer: str) -> str:
    """Sentence and table.

    Args:
        recording: the rollout.
        onpointer: JavaScript for a click on the table; it may use `step`.
    """
    color = "inherit" if recording.satisfied else BAD
    sentence = svg.escape(recording.diagnosis.sentence)
    hint = "Hover over a cell to read its robustness; click to go to its step."
    return (
        f'<div class="tg tg-monitor"><div class="tg-sentence" style="color:{color}">{sentence}'
        f'</div><div class="tg-rows">{_table(recording, onpointer)}</div>'
        f'<div class="tg-dim tg-readout">{hint}</div></div>'
    )


def _table(recording: Recording, onpointer: str) -> str:
    rows, steps = recording.rows, recording.steps
    bottom, cell = len(rows) * ROW, PLOT / (steps + 1)
    parts = [_label(row, i * ROW) for i, row in enumerate(rows)]
    parts += [_value(row, i * ROW) for i, row in enumerate(rows)]
    parts += [
        f'<image class="tg-cells-monitor" x="{LEFT}" y="{i * ROW}" width="{PLOT}" '
        f'height="{ROW - GAP}" preserveAspectRatio="none" href="{data_url(pixels(row, steps))}" '
        f'{_data(row, steps)} onpointermove="{svg.escape(_read_out(steps))}" '
        f'onpointerdown="{svg.escape(_step_under_pointer(steps) + onpointer)}"/>'
        for i, row in enumerate(rows)
    ]
    for tick in ticks(0, steps, 8):
        x = LEFT + (tick + 0.5) * cell
        parts.append(svg.text(x, bottom + 11, f"{tick:g}", size=10, anchor="middle", color=MUTED))
    step = recording.diagnosis.step
    if step is not None:
        parts.append(_pointer(LEFT + (step + 0.5) * cell, bottom, recording.satisfied))
    parts.append(playhead(LEFT + cell / 2, -2, bottom, cell))
    return svg.document(WIDTH, bottom + 16, parts, "robustness of the subformulas over time")


def pixels(row: MonitorRow, steps: int) -> np.ndarray:
    """Colours [1, T + 1, 3] of a row (uint8)."""
    known = row.signal[: steps + 1]
    strength = LEAST + (1 - LEAST) * np.tanh(np.abs(np.nan_to_num(known, nan=-9.0)) / FULL)
    matters = np.zeros(len(known), bool)
    for first, last in row.windows:
        matters[first : last + 1] = True
    strength = (strength * np.where(matters, 1.0, FAINT))[:, None]
    ink = np.where((known >= 0)[:, None], GREEN, RED)
    drawn = np.tile(np.array(UNDECIDED, float), (steps + 1, 1))
    drawn[: len(known)] = strength * ink + (1 - strength) * np.array(PALE)
    return drawn[None].round().astype(np.uint8)


def _label(row: MonitorRow, top: float) -> str:
    x, name = 2 + INDENT * row.depth, to_math(row.formula)
    most = int((LEFT - 6 - x) / svg.mono_width("x", SIZE))
    short = name if len(name) <= most else name[: max(most - 1, 1)] + "…"
    text = svg.text(x, top + ROW - 5, short, size=SIZE, mono=True)
    return f"<g><title>{svg.escape(name)}</title>{text}</g>"


def _value(row: MonitorRow, top: float) -> str:
    """Robustness at the only step at which a subformula matters, if there is just one."""
    if len(row.windows) != 1 or row.windows[0].start != row.windows[0].stop:
        return ""
    at = row.windows[0].start
    if at >= len(row.signal):
        return ""
    value = float(row.signal[at])
    color = "var(--mantine-color-text)" if value >= 0 else BAD
    return svg.text(
        WIDTH - 2, top + ROW - 5, f"{value:+.2f}", size=10, anchor="end", color=color, mono=True
    )


def _pointer(x: float, bottom: float, satisfied: bool) -> str:
    """A mark at the deciding step."""
    color = "#495057" if satisfied else BAD
    return (
        f'<line x1="{x:.1f}" y1="0" x2="{x:.1f}" y2="{bottom}" stroke="{color}" '
        'stroke-dasharray="3 2" pointer-events="none"><title>the deciding step</title></line>'
    )


def _step_under_pointer(steps: int) -> str:
    return (
        "const box=this.getBoundingClientRect(),step=Math.min("
        f"{steps},Math.max(0,Math.floor((event.clientX-box.left)/box.width*{steps + 1})));"
    )


def _data(row: MonitorRow, steps: int) -> str:
    """Attributes with what the read-out shows; scripts never contain user-given names."""
    values = " ".join(f"{value:+.2f}" for value in row.signal[: steps + 1])
    return f'data-name="{svg.escape(to_math(row.formula))}" data-values="{values}"'


def _read_out(steps: int) -> str:
    return (
        _step_under_pointer(steps)
        + "const value=this.dataset.values.split(' ')[step],"
        + "says=value?value+' m':'undecided: the rollout ends too early';"
        + "this.closest('.tg-monitor').querySelector('.tg-readout').textContent="
        + "'step '+step+': '+says+' for '+this.dataset.name;"
    )
