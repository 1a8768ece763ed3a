"""The regions: a list to select from, drawing tools, and exact values of the selected one."""

from functools import partial

import viser

from scenes import Region
from studio.page.editing.editor import CLICKED, INITIAL, SELECT, TOOLS
from studio.page.figures.svg import escape
from studio.page.panels.html import Html
from studio.page.panels.path_field import PathField
from studio.page.panels.predicates import PredicateFields
from studio.page.panels.region_fields import RegionFields
from studio.page.server.clicks import ClickField
from studio.page.session import Session
from studio.page.views.regions import region_look
from studio.page.views.roles import roles

ICONS = {SELECT: "↖", "rectangle": "▭", "circle": "◯", "box": "▭", "sphere": "◯", "cylinder": "▯"}
ICONS |= {"polygon": "⬠", "prism": "⬠"}
ACTIONS = ("undo", "redo", "duplicate", "delete", "start", "deselect", "close")


class RegionsPanel:
    """Tools and list as HTML buttons, the values as fields."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        with gui.add_folder("Regions"):
            self._clicks = ClickField(
                gui, lambda value: session.post(partial(press, session, value))
            )
            self._content = Html(gui)
            self._fields = RegionFields(gui, session)
            self._path = PathField(gui, session)
            self._predicates = PredicateFields(gui, session)

    def draw(self, session: Session) -> None:
        """Follow the document and the editor."""
        rows = (self._tools(session), self._list(session), self._actions(session))
        hint = f'<div class="tg-dim" style="margin-top:0.45em">{_hint(session)}</div>'
        chips = "".join(f'<div class="tg-chips">{row}</div>' for row in rows if row)
        self._content.show(f'<div class="tg tg-regions">{chips}{hint}</div>')
        self._fields.draw(session)
        self._path.draw(session)
        self._predicates.draw(session)

    def _tools(self, session: Session) -> str:
        editor, document = session.editor, session.document
        tools = "".join(
            self._button(f"tool {tool}", f"{ICONS[tool]} {tool}", pressed=tool == editor.tool)
            for tool in TOOLS[document.scene.dimension]
        )
        undo = self._button("undo", "↶", title=_title("Undo", document.undo_label, "Ctrl+Z"))
        redo = self._button("redo", "↷", title=_title("Redo", document.redo_label, "Ctrl+Shift+Z"))
        return f'{tools}<span class="tg-gap"></span>{undo}{redo}'

    def _list(self, session: Session) -> str:
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
        start = self._button("initial", "start", pressed=selection == INITIAL, dot="#f6bd60")
        return "".join([*chips, start])

    def _actions(self, session: Session) -> str:
        if session.editor.corners:
            return self._button(
                "close", "Close the polygon", title="Join the last corner to the first"
            )
        if not session.editor.selection:
            return ""
        return "".join(
            self._button(value, label, title=title)
            for value, label, title in (
                ("duplicate", "Duplicate", "Duplicate this region (D)"),
                ("delete", "Delete", "Delete this region (Delete)"),
                ("start", "Set as start", "Make this region the initial set"),
            )
        )

    def _button(
        self,
        value: str,
        label: str,
        *,
        pressed: bool | None = None,
        dot: str | None = None,
        title: str = "",
    ) -> str:
        script = escape(self._clicks.script(f"'{value}'"))
        state = "" if pressed is None else f' aria-pressed="{str(pressed).lower()}"'
        chip = f'<span class="tg-dot" style="background:{escape(dot)}"></span>' if dot else ""
        return (
            f'<button type="button"{state} title="{escape(title)}" data-act="{escape(value)}" '
            f'onclick="{script}">{chip}{escape(label)}</button>'
        )


def press(session: Session, value: str) -> None:
    """Act on a button; unknown values are ignored."""
    word, _, rest = value.partition(" ")
    editor, regions = session.editor, session.document.scene.regions
    if word == "region" and rest.isascii() and rest.isdigit() and int(rest) < len(regions):
        _toggle(session, regions[int(rest)].name)
    elif word == "tool":
        editor.take(rest)
    elif word == "initial":
        _toggle(session, INITIAL)
    elif word in ACTIONS:
        acts = {
            "undo": session.undo,
            "redo": session.redo,
            "duplicate": editor.duplicate,
            "delete": editor.delete,
            "start": editor.make_initial,
            "deselect": partial(editor.select, None),
            "close": editor.close,
        }
        acts[word]()


def _toggle(session: Session, target: str) -> None:
    editor = session.editor
    editor.select(None if editor.selection == target else target)


def _hint(session: Session) -> str:
    editor = session.editor
    if editor.preview is not None:
        return escape(_extent(editor.preview))
    if editor.tool in CLICKED:
        return (
            f"Click on the floor at each corner of the {escape(editor.tool)}; the first one again "
            "closes it. Esc takes the last corner away."
        )
    if editor.tool != SELECT:
        return f"Drag on the floor to draw a {escape(editor.tool)}. Esc puts the tool away."
    if editor.selected is not None:
        arrows = ", an arrow to move it along an axis" if editor.selected.dimension == 3 else ""
        return f"Drag the region to move it, a dot to resize it{arrows}. Esc deselects."
    return "Click a region to select it; Shift-drag on the floor to draw one."


def _extent(region: Region) -> str:
    if region.kind in ("circle", "sphere"):
        return f"{region.kind}, radius {region.size[0]:.2f} m"
    extent = " × ".join(f"{2 * value:.2f}" for value in region.size)
    return f"{region.kind}, {extent} m"


def _title(verb: str, label: str | None, keys: str) -> str:
    return f"{verb} ({keys})" + (f": {label}" if label else f": nothing to {verb.lower()}")
