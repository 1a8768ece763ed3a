"""The choice of a task or of a new mission, and a description of it."""

from collections.abc import Callable
from contextlib import suppress
from functools import partial

import viser

from core.errors import UserError
from envs import ENVS, VARIANTS
from scenes import Scene, blank, demo_names, load_task, task_names
from studio.page.editing.document import Document
from studio.page.figures.svg import escape
from studio.page.files.shelf import Shelf
from studio.page.panels.fields import set_changed
from studio.page.panels.html import Html, note
from studio.page.session import Session

STAY, GO = "Stay here", "Go anyway"
ENDS_TRAINING = "Opening another scene stops the running training and discards its policy."
DROPS_EDITS = "Opening another scene discards your unsaved changes."


SHIPPED = tuple(name for robot in ENVS for name in demo_names(robot) + task_names(robot))
CHOOSE = "choose a robot…"
NEW = "new"
"""Name of a new mission, if there is none yet."""

ROBOTS: dict[str, tuple[str, str]] = {
    f"{robot} ({variant})" if variant else robot: (robot, variant)
    for robot, variants in VARIANTS.items()
    for variant in ("", *variants)
}
"""Robot and variant by their label in the menu."""


class TaskPanel:
    """A menu of the user's own scenes and the shipped tasks; new missions."""

    def __init__(self, gui: viser.GuiApi, session: Session, shelf: Shelf) -> None:
        self._shelf = shelf
        self._own: Document | None = None
        """The document of the user's own scene that was opened last."""
        self._asked = 0
        """How often the menus were used."""
        scene = session.specification.scene
        if scene.name not in SHIPPED or scene != load_task(scene.name):
            self._own = session.document
            with suppress(UserError):  # autosave says what is wrong with the folder
                shelf.keep(scene)
        current = self._current(session)
        self._menu = gui.add_dropdown("Task", self._offered(current), initial_value=current)
        self._new = gui.add_dropdown("New mission", (CHOOSE, *ROBOTS), initial_value=CHOOSE)
        self._about = Html(gui)
        self._warning = Html(gui)
        self._answer = gui.add_button_group("", (STAY, GO), visible=False)

        @self._answer.on_click
        async def _(event: viser.GuiEvent) -> None:
            session.post(partial(session.confirm, event.target.value == GO))

        @self._menu.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                self._ask(session, partial(self._choose, session, event.target.value))

        @self._new.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None and event.target.value in ROBOTS:
                mission = ROBOTS[event.target.value]
                name = shelf.free_name(NEW)
                self._ask(session, lambda: session.open(blank(*mission, name)))

    def draw(self, session: Session) -> None:
        """Show the scene."""
        scene = session.specification.scene
        current = self._current(session)
        offered = self._offered(current)
        if self._menu.options != offered:
            self._menu.options = offered
        if self._menu.value != current:
            self._menu.value = current
        if self._new.value != CHOOSE:
            self._new.value = CHOOSE
        self._about.show(_about(scene))
        waits = session.leaving is not None
        self._warning.show(_losses(session) if waits else "")
        set_changed(self._answer, visible=waits)

    def _ask(self, session: Session, change: Callable[[], None]) -> None:
        self._asked += 1
        session.post(partial(self._take, session, change, self._asked))

    def _take(self, session: Session, change: Callable[[], None], number: int) -> None:
        """Open a scene, unless another has been chosen since: opening takes a while."""
        if number == self._asked:
            session.leave(change)

    def _choose(self, session: Session, label: str) -> None:
        for name, scene in self._shelf.scenes.items():
            if _own_label(name) == label:
                session.open(scene)
                self._own = session.document
                return
        session.choose_task(label)

    def _offered(self, current: str) -> tuple[str, ...]:
        """What the menu lists, each once; the scene shown, too."""
        own = map(_own_label, self._shelf.scenes)
        listed = tuple(dict.fromkeys((*own, *SHIPPED)))
        return listed if current in listed else (current, *listed)

    def _current(self, session: Session) -> str:
        name = session.specification.scene.name
        return _own_label(name) if session.document is self._own else name


def _own_label(name: str) -> str:
    """Of one of the user's scenes, which may have a shipped task's name."""
    return f"{name} (yours)" if name in SHIPPED else name


def _losses(session: Session) -> str:
    """What a change of scene would discard."""
    training = note(ENDS_TRAINING, "warn") if session.training.busy else ""
    return training + (note(DROPS_EDITS, "warn") if session.unsaved else "")


def _about(scene: Scene) -> str:
    robot = ENVS[scene.robot]
    return (
        f'<div class="tg"><div class="tg-title">{escape(scene.title)}</div>'
        f'<div class="tg-dim">{escape(robot.name.capitalize())} robot · {robot.dt:g} s per step · '
        f"{len(scene.regions)} region{'' if len(scene.regions) == 1 else 's'}</div></div>"
    )
