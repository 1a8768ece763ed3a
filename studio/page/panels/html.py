"""An HTML element that is sent only when it changes."""

import viser

from studio.page.figures.svg import escape


class Html:
    """Shows HTML in a panel; hidden while empty."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self._handle = gui.add_html("", visible=False)
        self._content = ""

    def show(self, content: str) -> None:
        """Replace the content."""
        if content != self._content:
            self._content = content
            self._handle.content = content
            self._handle.visible = bool(content)


def note(message: str, kind: str = "error") -> str:
    """A message to the user, `error`, `warn` or `info`, empty for none; line breaks are kept."""
    if not message:
        return ""
    sentence, _, rest = message.partition("\n")
    excerpt = f"<pre>{escape(rest)}</pre>" if rest else ""
    return (
        f'<div class="tg"><div class="tg-note tg-{kind}" role="alert">'
        f"<div>{escape(sentence)}</div>{excerpt}</div></div>"
    )
