"""The monitor table of the rollout on screen, and the playheads of all figures."""

from functools import partial

import viser

from studio.figures.monitor import monitor_html
from studio.figures.playhead import playhead_style
from studio.panels.html import Html
from studio.playing.recording import Recording
from studio.server.clicks import ClickField
from studio.session import Session

EMPTY = '<div class="tg tg-dim">Shows which subformula held when, once a rollout is there.</div>'


class MonitorPanel:
    """Subformula x time; a click goes to a step."""

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
    """Moves the lines of the playhead in all figures."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._style = Html(gui)

    def draw(self, session: Session) -> None:
        """Follow the playhead."""
        self._style.show(playhead_style(session.player.position))


def _seek(session: Session, value: str) -> None:
    """Go to a step that a page sent; what is no step is ignored."""
    if value.isdecimal() and len(value) < 6:
        session.player.seek(int(value))
