"""Clicks inside an HTML element, delivered to Python.

Images and HTML of the viewer library report no clicks. Its page does expose, for its own tests,
`window.__viserMutable.sendMessage`; with it a script in an attribute sets the value of a text
field that is not shown. This file is the only one that knows; the library's version is pinned.
"""

from collections.abc import Callable

import viser


class ClickField:
    """Receives values that scripts in HTML attributes send."""

    def __init__(self, gui: viser.GuiApi, receive: Callable[[str], None]) -> None:
        self._field = gui.add_text("", "", visible=False)

        @self._field.on_update
        async def _(event: viser.GuiEvent[viser.GuiTextHandle]) -> None:
            receive(event.target.value.rpartition(" ")[0])

    def script(self, expression: str) -> str:
        """JavaScript that sends the value of an expression (a string of the page's own making).

        The time is added, so that the same value twice is two clicks.
        """
        message = (
            f"{{type:'GuiUpdateMessage',uuid:'{self._field._impl.uuid}',"  # noqa: SLF001
            f"updates:{{value:({expression})+' '+Date.now()}}}}"
        )
        return f"window.__viserMutable.sendMessage({message});"
