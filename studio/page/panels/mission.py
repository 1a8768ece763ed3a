"""What frames a mission: its name and title, its horizon and its arena."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import viser

from core.errors import UserError
from scenes import Scene, robot_of, unit_of, workspace_of
from scenes.arena import Arena
from studio.page.editing.document import Document
from studio.page.panels.fields import PAUSE, set_changed
from studio.page.panels.html import Html, note
from studio.page.session import Session

FINE = 0.5
"""Step of the arrows at the arena's corners, in units of the scene."""

DIGITS = 3
"""Decimal places of the corners: millimetres."""


def fence(document: Document, arena: Arena) -> None:
    """Change the arena; the robot's own is not written down."""
    own = robot_of(document.scene).workspace.arena
    document.set_arena(None if arena == own else arena)


CHANGES: dict[str, Callable[[Document, Any], None]] = {
    "name": Document.set_name,
    "title": Document.set_title,
    "horizon": Document.set_horizon,
    "arena": fence,
}
"""What is typed here, and the edit that applies it."""


class Typed(NamedTuple):
    """A value that the scene does not have yet."""

    document: Document
    value: Any
    due: float
    """When it is applied: monotonic time [s]."""


class Refused(NamedTuple):
    """Why the last value was refused; told until something is changed."""

    document: Document
    revision: int
    reason: str


class MissionFields:
    """Fields that follow the scene; a value that is refused is replaced by the scene's."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        scene = session.document.scene
        self._session = session
        self._typed: dict[str, Typed] = {}
        """By the keys of `CHANGES`."""
        self._refused: Refused | None = None
        with gui.add_folder("Mission", expand_by_default=False):
            self._plain = {
                "name": gui.add_text("Name", scene.name),
                "title": gui.add_text("Title", scene.title),
                "horizon": gui.add_number(
                    "Horizon (steps)", scene.horizon, step=10, hint="Least length of an episode"
                ),
            }
            self._corners = {
                2: (
                    gui.add_vector2("Arena from (m)", (0.0, 0.0), visible=False),
                    gui.add_vector2("Arena to (m)", (1.0, 1.0), visible=False),
                ),
                3: (
                    gui.add_vector3("Arena from (m)", (0.0, 0.0, 0.0), visible=False),
                    gui.add_vector3("Arena to (m)", (1.0, 1.0, 1.0), visible=False),
                ),
            }
            self._own = gui.add_button("The robot's own arena", color="gray", visible=False)
            self._problem = Html(gui)
        for what, field in self._plain.items():
            self._on_update(field, what, partial(getattr, field, "value"))
        for low, high in self._corners.values():
            for field in (low, high):
                field.precision = DIGITS
                self._on_update(field, "arena", partial(_arena, low, high))

        @self._own.on_click
        async def _(_: viser.GuiEvent) -> None:
            session.post(lambda: session.document.set_arena(None))

    def draw(self, session: Session) -> None:
        """Apply what was typed when typing pauses; show the scene in all other fields."""
        now = time.monotonic()
        for what, typed in list(self._typed.items()):
            if now >= typed.due:
                session.post(partial(self._apply, what, typed))
        scene = session.document.scene
        for what, field in self._plain.items():
            if what not in self._typed:
                set_changed(field, value=getattr(scene, what))
        self._show_arena(scene)
        self._problem.show(note(self._reason(session.document)))

    def _show_arena(self, scene: Scene) -> None:
        arena = workspace_of(scene).arena
        for dimension, corners in self._corners.items():
            for field, values in zip(corners, zip(*arena, strict=True), strict=True):
                if dimension == scene.dimension and "arena" not in self._typed:
                    set_changed(field, step=FINE * unit_of(scene))
                    set_changed(field, value=tuple(map(float, values)))
                set_changed(field, visible=dimension == scene.dimension)
        set_changed(self._own, visible=scene.arena is not None)

    def _reason(self, document: Document) -> str:
        refused = self._refused
        if refused is None or refused[:2] != (document, document.revision):
            return ""
        return refused.reason

    def _on_update(self, field: Any, what: str, value: Callable[[], Any]) -> None:
        @field.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                due = time.monotonic() + PAUSE
                self._typed[what] = Typed(self._session.document, value(), due)

    def _apply(self, what: str, typed: Typed) -> None:
        """Change the scene that was typed for, unless another is open or more was typed."""
        latest = self._typed.pop(what, None)
        if latest is not typed:
            if latest is not None:
                self._typed.setdefault(what, latest)
            return
        self._refused = None
        document = typed.document
        if self._session.document is document:
            try:
                CHANGES[what](document, typed.value)
            except UserError as error:
                self._refused = Refused(document, document.revision, str(error))


def _arena(low: Any, high: Any) -> Arena:
    """The arena between the corners in two fields."""
    return tuple((float(a), float(b)) for a, b in zip(low.value, high.value, strict=True))
