"""Autosave, and the offer to recover work after a crash."""

import time
from functools import partial
from pathlib import Path

import viser

from core.errors import UserError
from studio.page.figures.svg import escape
from studio.page.files.projects import Autosave, ProjectError, Recoverable, discard, recoverable
from studio.page.panels.fields import set_changed
from studio.page.panels.html import Html, note
from studio.page.session import Session

PERIOD = 2.0
"""Time between two checks for unsaved changes [s]."""


class RecoveryPanel:
    """Invisible, unless there is work to recover or autosave fails."""

    def __init__(self, gui: viser.GuiApi, session: Session, folder: Path) -> None:
        self._session, self._folder = session, folder
        self._left: Recoverable | None = next(iter(recoverable(folder)), None)
        self._problem, self._due = "", 0.0
        self._autosave: Autosave | None = None
        try:
            self._autosave = Autosave(folder)
        except UserError as error:
            self._problem = str(error)
        self._note = Html(gui)
        self._choice = gui.add_button_group("", ("Recover", "Discard"), visible=False)

        @self._choice.on_click
        async def _(event: viser.GuiEvent) -> None:
            session.post(partial(self._choose, event.target.value))

    def draw(self, session: Session) -> None:
        """Save changes; show the offer."""
        now = time.monotonic()
        if self._autosave is not None and now >= self._due:
            self._due = now + PERIOD
            self._save(self._autosave, session)
        set_changed(self._choice, visible=self._left is not None)
        self._note.show(_offer(self._left) + note(self._problem, "warn"))

    def close(self) -> None:
        """Stop autosave; unsaved work can be recovered later."""
        if self._autosave is not None:
            self._autosave.close(keep=self._session.document.modified)

    def _save(self, autosave: Autosave, session: Session) -> None:
        if not session.document.modified:
            autosave.clear()
            return
        try:
            autosave.save(session.document.scene)
            self._problem = ""
        except UserError as error:
            self._problem = f"Autosave failed. {error}"

    def _choose(self, choice: str) -> None:
        """Recover or discard the work that was left."""
        left = self._left
        if left is None:
            return
        if choice == "Recover":
            self._session.leave(partial(self._recover, left))
        else:
            self._drop(left)

    def _recover(self, left: Recoverable) -> None:
        """Open the recovered work, still unsaved; delete the old autosave once saved again."""
        self._session.open(left.scene, saved=False)
        self._left = None
        if self._autosave is not None:
            self._save(self._autosave, self._session)
            if not self._problem:
                self._drop(left)

    def _drop(self, left: Recoverable) -> None:
        """Delete the work that was left; it is not offered again."""
        self._left = None
        try:
            discard(left.session, self._folder)
        except ProjectError as error:
            self._problem = str(error)


def _offer(left: Recoverable | None) -> str:
    if left is None:
        return ""
    when = time.strftime("%Y-%m-%d %H:%M", time.localtime(left.saved_at))
    return (
        '<div class="tg"><div class="tg-note tg-warn tg-recovery">Unsaved work on '
        f"<b>{escape(left.scene.name)}</b> from {when} can be recovered.</div></div>"
    )
