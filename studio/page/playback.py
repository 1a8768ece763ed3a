"""Playback keys: Space plays and pauses, the arrow keys step."""

from functools import partial

import viser
from viser._messages import HotkeyKey  # not re-exported by the library

from studio.page.session import Session

ARROWS: tuple[tuple[str, HotkeyKey, int], ...] = (
    ("Step back", "arrowleft", -1),
    ("Step forward", "arrowright", 1),
)
STRIDE = 10
"""Steps of an arrow key with Shift."""


def add_playback_commands(gui: viser.GuiApi, session: Session) -> None:
    """Register the commands in the viewer's palette."""
    play = gui.add_command("Play or pause", hotkey="space")
    play.on_trigger(partial(_toggle, session))
    for label, key, steps in ARROWS:
        gui.add_command(label, hotkey=key).on_trigger(partial(_step, session, steps))
        far = gui.add_command(f"{label} by {STRIDE}", hotkey=key, modifier="shift")
        far.on_trigger(partial(_step, session, STRIDE * steps))


async def _toggle(session: Session, event: object) -> None:
    session.post(session.player.toggle)


async def _step(session: Session, steps: int, event: object) -> None:
    session.post(partial(session.player.step, steps))
