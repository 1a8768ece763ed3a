"""Shortcuts: commands in the viewer's palette (Ctrl+K or Cmd+K lists them), most with a key.

The viewer does not deliver keys pressed while a text field has the focus.
"""

from collections.abc import Callable
from typing import NamedTuple

import viser
from viser._messages import HotkeyKey, KeyModifier  # not re-exported by the library

from studio.page.session import Session


class Command(NamedTuple):
    """An entry of the palette and its action, run on the page's loop."""

    label: str
    key: HotkeyKey | None
    modifier: KeyModifier | None
    act: Callable[[Session], None]


COMMANDS = (
    Command("Undo", "Z", "cmd/ctrl", lambda session: session.undo()),
    Command("Redo", "Z", "cmd/ctrl+shift", lambda session: session.redo()),
    Command("Redo (Ctrl+Y)", "Y", "cmd/ctrl", lambda session: session.redo()),
    Command("Select tool", "V", None, lambda session: session.editor.take_tool(0)),
    Command("Draw a rectangle or box", "R", None, lambda session: session.editor.take_tool(1)),
    Command("Draw a circle or sphere", "C", None, lambda session: session.editor.take_tool(2)),
    Command("Duplicate the region", "D", None, lambda session: session.editor.duplicate()),
    Command("Delete the region", "delete", None, lambda session: session.editor.delete()),
    Command("Join with another region", "J", None, lambda session: session.editor.join()),
    Command("Take the region apart", None, None, lambda session: session.editor.take_apart()),
    Command("Cancel", "escape", None, lambda session: session.editor.cancel()),
)


def add_commands(gui: viser.GuiApi, session: Session) -> None:
    """Register the commands."""
    for command in COMMANDS:
        _add(gui, session, command)


def _add(gui: viser.GuiApi, session: Session, command: Command) -> None:
    handle = gui.add_command(command.label, hotkey=command.key, modifier=command.modifier)

    @handle.on_trigger
    async def _(_) -> None:
        session.post(lambda: command.act(session))
