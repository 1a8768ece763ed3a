"""The regions: a list to select from, drawing tools, and exact values of the selected one."""

from collections.abc import Callable
from functools import partial

import viser

from scenes import Region
from studio.page.editing.editor import CLICKED, SELECT
from studio.page.editing.selection import INITIAL
from studio.page.editing.turning import TURNABLE
from studio.page.figures.svg import escape
from studio.page.panels.html import Html
from studio.page.panels.path_field import PathField
from studio.page.panels.predicates import PredicateFields
from studio.page.panels.region_buttons import RegionButtons
from studio.page.panels.region_fields import RegionFields
from studio.page.server.clicks import ClickField
from studio.page.session import Session


class RegionsPanel:
    """Tools and list as HTML buttons, the values as fields."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        with gui.add_folder("Regions"):
            clicks = ClickField(gui, lambda value: session.post(partial(press, session, value)))
            self._buttons = RegionButtons(clicks)
            self._content = Html(gui)
            self._fields = RegionFields(gui, session)
            self._path = PathField(gui, session)
        self._predicates = PredicateFields(gui, session)

    def draw(self, session: Session) -> None:
        """Follow the document and the editor."""
        hint = f'<div class="tg-dim" style="margin-top:0.45em">{escape(hint_for(session))}</div>'
        self._content.show(f'<div class="tg tg-regions">{self._buttons.html(session)}{hint}</div>')
        self._fields.draw(session)
        self._path.draw(session)
        self._predicates.draw(session)


def press(session: Session, value: str) -> None:
    """Act on a button; unknown values are ignored."""
    word, _, rest = value.partition(" ")
    editor, regions = session.editor, session.document.scene.regions
    index = int(rest) if rest.isascii() and rest.isdigit() and len(rest) < 4 else None
    if word == "region" and index is not None and index < len(regions):
        _toggle(session, regions[index].name)
    elif word == "part":
        editor.select(editor.selection, index)
    elif word == "tool":
        editor.take(rest)
    elif word == "initial":
        _toggle(session, INITIAL)
    elif word in ACTIONS:
        ACTIONS[word](session)


ACTIONS: dict[str, Callable[[Session], None]] = {
    "undo": lambda session: session.undo(),
    "redo": lambda session: session.redo(),
    "duplicate": lambda session: session.editor.duplicate(),
    "delete": lambda session: session.editor.delete(),
    "start": lambda session: session.editor.make_initial(),
    "join": lambda session: session.editor.join(),
    "apart": lambda session: session.editor.take_apart(),
    "deselect": lambda session: session.editor.select(None),
    "close": lambda session: session.editor.close(),
}


def _toggle(session: Session, target: str) -> None:
    editor = session.editor
    if editor.selection == target:
        editor.select(None)
    else:
        editor.click(target)


def hint_for(session: Session) -> str:
    """What the pointer does now."""
    editor = session.editor
    if editor.preview is not None:
        return _extent(editor.preview)
    if editor.tool in CLICKED:
        return (
            f"Click on the floor at each corner of the {editor.tool}; the first one again "
            "closes it. Esc takes the last corner away."
        )
    if editor.tool != SELECT:
        return f"Drag on the floor to draw a {editor.tool}. Esc puts the tool away."
    if editor.joining:
        return (
            f"Click the regions that become part of {editor.selection}, here or in the scene. "
            "The formula will name it instead of them. Esc ends."
        )
    if editor.vertex is not None:
        return "Delete takes the orange corner away; Esc keeps it."
    if editor.selected is not None:
        return _grips(editor.selected, part=editor.part is not None)
    return "Click a region to select it; Shift-drag on the floor to draw one."


def _grips(region: Region, *, part: bool) -> str:
    """What of a selected shape can be dragged."""
    if region.kind == "point":
        return "Drag the point to move it. Esc deselects."
    said = [f"Drag the {'part' if part else 'region'} to move it"]
    if region.points:
        said.append("a corner to move that, a small dot to add one")
    elif not region.parts:
        said.append("a dot to resize it")
    if region.dimension == 3:
        said.append("an arrow to move it along an axis")
    if region.kind in TURNABLE:
        said.append("the orange dot to turn it (by 5°, with Shift freely)")
    click = " Click a corner to delete it." if region.points else ""
    click = " Click it once more to select one of its parts." if region.parts else click
    return f"{', '.join(said)}.{click} Esc deselects."


def _extent(region: Region) -> str:
    if region.kind in ("circle", "sphere"):
        return f"{region.kind}, radius {region.size[0]:.2f} m"
    extent = " × ".join(f"{2 * value:.2f}" for value in region.size)
    return f"{region.kind}, {extent} m"
