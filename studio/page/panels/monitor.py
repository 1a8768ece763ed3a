"""The monitor table of the rollout on screen, and the playheads of all figures."""

from functools import partial

import viser

from studio.page.figures.monitor import monitor_html
from studio.page.figures.playhead import playhead_style
from studio.page.panels.html import Html
from studio.page.server.clicks import ClickField
from studio.page.session import Session
from studio.runs.recording import Recording

EMPTY = '<div class="tg tg-dim">After a rollout, shows when each subformula held.</div>'


class MonitorPanel:
    """Subformulas over time; a click goes to a step."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._recording: Recording | None = None
        self._clicks = ClickField(gui, lambda value: session.post(partial(_seek, session, value)))
        self._table = Html(gui)
        self._table.show(EMPTY)

    def draw(self, session: Session) -> None:
        """Show the recording."""
        recording = session.player.recording
        if recording is self._recording:
            return
        self._recording = recording
        script = self._clicks.script("''+step")
        self._table.show(EMPTY if recording is None else monitor_html(recording, script))


class PlayheadStyle:
    """Moves the playhead's line in all figures."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._style = Html(gui)

    def draw(self, session: Session) -> None:
        """Follow the playhead."""
        self._style.show(playhead_style(session.player.position))


def _seek(session: Session, value: str) -> None:
    """Go to a step sent by the page; anything else is ignored."""
    if value.isdecimal() and len(value) < 6:
        session.player.seek(int(value))
