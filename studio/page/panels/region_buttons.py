"""Rows of buttons over the regions: tools, regions, parts, and what is done with a selection."""

from scenes import Region
from studio.page.editing.editor import SELECT, TOOLS
from studio.page.editing.selection import INITIAL
from studio.page.figures.svg import escape
from studio.page.server.clicks import ClickField
from studio.page.session import Session
from studio.page.views.regions import START, region_look
from studio.page.views.roles import roles

ICONS = {SELECT: "↖", "rectangle": "▭", "circle": "◯", "box": "▭", "sphere": "◯", "cylinder": "▯"}
ICONS |= {"polygon": "⬠", "prism": "⬠"}


class RegionButtons:
    """Buttons as HTML; each sends what `press` of the regions panel understands."""

    def __init__(self, clicks: ClickField) -> None:
        self._clicks = clicks

    def html(self, session: Session) -> str:
        """All rows that there is something to show in."""
        rows = (
            self._tools(session),
            self._regions(session),
            self._parts(session),
            self._actions(session),
        )
        return "".join(f'<div class="tg-chips">{row}</div>' for row in rows if row)

    def _tools(self, session: Session) -> str:
        editor, document = session.editor, session.document
        tools = "".join(
            self._button(f"tool {tool}", f"{ICONS[tool]} {tool}", pressed=tool == editor.tool)
            for tool in TOOLS[document.scene.dimension]
        )
        undo = self._button("undo", "↶", title=_title("Undo", document.undo_label, "Ctrl+Z"))
        redo = self._button("redo", "↷", title=_title("Redo", document.redo_label, "Ctrl+Shift+Z"))
        return f'{tools}<span class="tg-together">{undo}{redo}</span>'

    def _regions(self, session: Session) -> str:
        scene, selection = session.document.scene, session.editor.selection
        found = roles(scene.region_names, session.specification.decomposition)
        chips = [
            self._button(
                f"region {index}",
                region.name,
                pressed=selection == region.name,
                dot=region_look(region, found[region.name]).color,
            )
            for index, region in enumerate(scene.regions)
        ]
        start = self._button("initial", "start", pressed=selection == INITIAL, dot=START)
        return "".join([*chips, start])

    def _parts(self, session: Session) -> str:
        union, part = session.editor.whole, session.editor.part
        if union is None or not union.parts:
            return ""
        chips = [self._button("part", "whole", pressed=part is None)]
        chips += [
            self._button(f"part {index}", _numbered(index, each), pressed=part == index)
            for index, each in enumerate(union.parts)
        ]
        return f'<span class="tg-dim">Parts</span>{"".join(chips)}'

    def _actions(self, session: Session) -> str:
        editor = session.editor
        if editor.corners:
            return self._button(
                "close", "Close the polygon", title="Join the last corner to the first"
            )
        if editor.vertex is not None:
            title = "Take the orange corner away (Delete)"
            return self._button("delete", "Delete this corner", title=title)
        if not editor.selection:
            return ""
        if editor.part is not None:
            return self._button(
                "duplicate", "Duplicate part", title="Add a copy of this part (D)"
            ) + self._button("delete", "Delete part", title="Delete this part (Delete)")
        buttons = [
            ("duplicate", "Duplicate", "Duplicate this region (D)"),
            ("delete", "Delete", "Delete this region (Delete)"),
            ("start", "Set as start", "Make this region the initial set"),
        ]
        row = "".join(self._button(*button) for button in buttons)
        row += self._button(
            "join",
            "Join with…",
            pressed=editor.joining,
            title="Make other regions part of this one (J)",
        )
        if editor.whole is not None and editor.whole.parts:
            row += self._button("apart", "Take apart", title="Make each part a region of its own")
        return row

    def _button(
        self,
        value: str,
        label: str,
        title: str = "",
        *,
        pressed: bool | None = None,
        dot: str | None = None,
    ) -> str:
        script = escape(self._clicks.script(f"'{value}'"))
        state = "" if pressed is None else f' aria-pressed="{str(pressed).lower()}"'
        chip = f'<span class="tg-dot" style="background:{escape(dot)}"></span>' if dot else ""
        return (
            f'<button type="button"{state} title="{escape(title)}" data-act="{escape(value)}" '
            f'onclick="{script}">{chip}{escape(label)}</button>'
        )


def _numbered(index: int, part: Region) -> str:
    return f"{index + 1} {part.kind}"


def _title(verb: str, label: str | None, keys: str) -> str:
    return f"{verb} ({keys})" + (f": {label}" if label else f": nothing to {verb.lower()}")
