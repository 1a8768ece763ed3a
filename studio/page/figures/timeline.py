"""A rollout's tasks over time: a bar for each window, green where its predicate held."""

from collections.abc import Sequence

import numpy as np

from core.decompose import Kind
from studio.page.figures import svg
from studio.page.figures.playhead import playhead
from studio.page.figures.ticks import ticks
from studio.runs.recording import Outcome, Recording
from studio.theme import BAD, BRAND, GOOD, MUTED

WIDTH, LEFT, RIGHT, ROW, BAR = 560, 96, 14, 17, 9  # [px]
PLOT = WIDTH - LEFT - RIGHT


def timeline_svg(recording: Recording) -> str:
    """Draw the windows of all tasks over the steps of the episode."""
    rows = grouped(recording.outcomes)
    bottom = len(rows) * ROW + 4
    parts = [
        *(_grid(tick, recording.steps, bottom) for tick in ticks(0, recording.steps, 11)),
        *(part for i, row in enumerate(rows) for part in _row(row, i * ROW + 2, recording.steps)),
        *(_move(step, recording.steps, bottom) for step in recording.moves),
        playhead(LEFT, 0, bottom, PLOT / max(recording.steps, 1)),
    ]
    return svg.document(WIDTH, bottom + 14, parts, "tasks over time")


def grouped(outcomes: Sequence[Outcome]) -> list[list[Outcome]]:
    """Outcomes in rows; invariants that held over one window share a row."""
    rows: dict[object, list[Outcome]] = {}
    for index, outcome in enumerate(outcomes):
        shared = outcome.kind is Kind.INVARIANT and outcome.worst >= 0
        rows.setdefault((outcome.start, outcome.end) if shared else index, []).append(outcome)
    return list(rows.values())


def runs(outcome: Outcome) -> list[tuple[int, int, bool]]:
    """Maximal runs (first step, last step, whether it held) of the window."""
    held = outcome.margin[outcome.start : outcome.end + 1] >= 0
    edges = np.flatnonzero(np.diff(held)) + 1
    starts = [0, *edges.tolist()]
    ends = [*(edges - 1).tolist(), held.size - 1]
    return [
        (outcome.start + a, outcome.start + b, bool(held[a]))
        for a, b in zip(starts, ends, strict=True)
    ]


def _row(row: list[Outcome], top: float, steps: int) -> list[str]:
    name = row[0].predicate if len(row) == 1 else f"{row[0].predicate} … {row[-1].predicate}"
    holds = all(outcome.worst >= 0 for outcome in row)
    label = svg.text(
        LEFT - 8,
        top + BAR + 1,
        name if len(name) <= 14 else name[:13] + "…",
        anchor="end",
        color="var(--mantine-color-text)" if holds else BAD,
        mono=True,
        size=10.5,
    )
    hint = svg.escape("\n".join(f"{outcome.name}: {outcome.predicate}" for outcome in row))
    bars = [_bar(*run, top, steps) for run in runs(row[0])]
    return [f"<g><title>{hint}</title>{label}{''.join(bars)}</g>"]


def _bar(first: int, last: int, held: bool, top: float, steps: int) -> str:
    x, end = _x(first - 0.5, steps), _x(last + 0.5, steps)
    width = max(end - x, 7.0)
    x = min(max((x + end - width) / 2, LEFT), LEFT + PLOT - width)
    return (
        f'<rect x="{x:.1f}" y="{top + 2}" width="{width:.1f}" height="{BAR}" rx="2" '
        f'fill="{GOOD if held else BAD}" fill-opacity="0.8"/>'
    )


def _move(step: int, steps: int, bottom: float) -> str:
    x, hint = _x(step, steps), f"the robot was moved at step {step}"
    return (
        f'<line class="tg-moved" x1="{x:.1f}" y1="0" x2="{x:.1f}" y2="{bottom}" '
        f'stroke="rgb{BRAND}" stroke-dasharray="3 2"><title>{hint}</title></line>'
    )


def _x(step: float, steps: int) -> float:
    return LEFT + PLOT * min(max(step / max(steps, 1), 0.0), 1.0)


def _grid(step: float, steps: int, bottom: float) -> str:
    x = _x(step, steps)
    return (
        f'<line x1="{x:.1f}" y1="2" x2="{x:.1f}" y2="{bottom}" '
        'stroke="var(--mantine-color-default-border)"/>'
        + svg.text(x, bottom + 11, f"{step:g}", size=10, anchor="middle", color=MUTED)
    )
