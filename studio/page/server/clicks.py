"""Clicks inside an HTML element, delivered to Python.

Images and HTML of the viewer library report no clicks. Its page exposes, for its own tests,
`window.__viserMutable.sendMessage`; with it, a script in an attribute sets the value of a hidden
text field. Only this file depends on that; the library's version is pinned.
"""

from collections.abc import Callable

import viser

from studio.page.server.relied_upon import identifier_of


class ClickField:
    """Receives values that scripts in HTML attributes send."""

    def __init__(self, gui: viser.GuiApi, receive: Callable[[str], None]) -> None:
        self._field = gui.add_text("", "", visible=False)

        @self._field.on_update
        async def _(event: viser.GuiEvent[viser.GuiTextHandle]) -> None:
            receive(event.target.value.rpartition(" ")[0])

    def script(self, expression: str) -> str:
        """JavaScript that sends the value of an expression (a string made by the page itself).

        The time is appended, so that sending the same value twice is two clicks.
        """
        message = (
            f"{{type:'GuiUpdateMessage',uuid:'{identifier_of(self._field)}',"
            f"updates:{{value:({expression})+' '+Date.now()}}}}"
        )
        return f"window.__viserMutable.sendMessage({message});"
