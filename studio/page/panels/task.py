"""The choice of a task or of a new mission, and a description of it."""

from collections.abc import Callable
from functools import partial

import viser

from envs import ENVS, VARIANTS
from scenes import Scene, blank, demo_names, task_names
from studio.page.figures.svg import escape
from studio.page.panels.html import Html, note
from studio.page.session import Session

STAY, GO = "Stay here", "Go anyway"
ENDS_TRAINING = "Opening another scene stops the running training and discards its policy."
DROPS_EDITS = "Opening another scene discards your unsaved changes."


CHOOSE = "choose a robot…"

ROBOTS: dict[str, tuple[str, str]] = {
    f"{robot} ({variant})" if variant else robot: (robot, variant)
    for robot, variants in VARIANTS.items()
    for variant in ("", *variants)
}
"""Robot and variant by their label in the menu."""


class TaskPanel:
    """A menu of the shipped tasks, and of the opened file if there is one; new missions."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        scene = session.specification.scene
        self._opened = scene
        self._asked = 0
        """How often the menu was used."""
        names = [name for robot in ENVS for name in demo_names(robot) + task_names(robot)]
        if scene.name not in names:
            names.insert(0, scene.name)
        self._menu = gui.add_dropdown("Task", names, initial_value=scene.name)
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
                self._ask(session, lambda: session.open(blank(*mission)))

    def draw(self, session: Session) -> None:
        """Show the scene."""
        scene = session.specification.scene
        self._menu.value = scene.name
        if self._new.value != CHOOSE:
            self._new.value = CHOOSE
        self._about.show(_about(scene))
        waits = session.leaving is not None
        self._warning.show(_losses(session) if waits else "")
        if self._answer.visible != waits:
            self._answer.visible = waits

    def _ask(self, session: Session, change: Callable[[], None]) -> None:
        self._asked += 1
        session.post(partial(self._take, session, change, self._asked))

    def _take(self, session: Session, change: Callable[[], None], number: int) -> None:
        """Open a scene, unless another has been chosen since: opening takes a while."""
        if number == self._asked:
            session.leave(change)

    def _choose(self, session: Session, name: str) -> None:
        if name == self._opened.name:
            session.open(self._opened)
        else:
            session.choose_task(name)


def _losses(session: Session) -> str:
    """What a change of scene would discard."""
    training = note(ENDS_TRAINING, "warn") if session.training.busy else ""
    return training + (note(DROPS_EDITS, "warn") if session.unsaved else "")


def _about(scene: Scene) -> str:
    robot = ENVS[scene.robot]
    return (
        f'<div class="tg"><div class="tg-title">{escape(scene.title)}</div>'
        f'<div class="tg-dim">{escape(robot.name.capitalize())} robot · {robot.dt:g} s per step · '
        f"{len(scene.regions)} regions</div></div>"
    )
