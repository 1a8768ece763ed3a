"""The playhead in figures: a line moved by a short style sheet, so no figure is resent."""

from studio.theme import TRAIL


def playhead(left: float, top: float, bottom: float, step: float) -> str:
    """A vertical line that stands at step 0 at `left`, with `step` pixels a step [px]."""
    return (
        f'<line class="tg-playhead" x1="{left:.1f}" y1="{top}" x2="{left:.1f}" y2="{bottom}" '
        f'stroke="rgb{TRAIL}" stroke-width="1.6" pointer-events="none" '
        f'style="transform:translateX(calc(var(--tg-step, 0) * {step:.4f}px))"/>'
    )


def playhead_style(position: float) -> str:
    """Style sheet that moves all playheads to a position [steps]."""
    return f"<style>.tg-playhead{{--tg-step:{position:.2f}}}</style>"
