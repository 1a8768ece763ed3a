"""The choice of a task, and what it is about."""

from functools import partial

import viser

from envs import ENVS
from scenes import Scene, demo_names, task_names
from studio.figures.svg import escape
from studio.panels.html import Html, note
from studio.session import Session

STAY, GO = "Stay here", "Go anyway"
ENDS_TRAINING = "Another scene ends the training that runs; what it has learnt is lost."
DROPS_EDITS = "Another scene takes the place of this one; its unsaved changes are lost."


class TaskPanel:
    """A menu of the shipped tasks, with the opened file's name if there is one."""

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        scene = session.specification.scene
        self._opened = scene
        names = [name for robot in ENVS for name in demo_names(robot) + task_names(robot)]
        if scene.name not in names:
            names.insert(0, scene.name)
        self._menu = gui.add_dropdown("Task", names, initial_value=scene.name)
        self._about = Html(gui)
        self._warning = Html(gui)
        self._answer = gui.add_button_group("", (STAY, GO), visible=False)

        @self._answer.on_click
        async def _(event: viser.GuiEvent) -> None:
            session.post(partial(session.confirm, event.target.value == GO))

        @self._menu.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                change = partial(self._choose, session, event.target.value)
                session.post(partial(session.leave, change))

    def draw(self, session: Session) -> None:
        """Show the scene."""
        scene = session.specification.scene
        self._menu.value = scene.name
        self._about.show(_about(scene))
        waits = session.leaving is not None
        self._warning.show(_losses(session) if waits else "")
        if self._answer.visible != waits:
            self._answer.visible = waits

    def _choose(self, session: Session, name: str) -> None:
        if name == self._opened.name:
            session.open(self._opened)
        else:
            session.choose_task(name)


def _losses(session: Session) -> str:
    """What a change of scene would cost now."""
    training = note(ENDS_TRAINING, "warn") if session.training.busy else ""
    return training + (note(DROPS_EDITS, "warn") if session.unsaved else "")


def _about(scene: Scene) -> str:
    robot = ENVS[scene.robot]
    return (
        f'<div class="tg"><div class="tg-title">{escape(scene.title)}</div>'
        f'<div class="tg-dim">{escape(robot.name.capitalize())} robot · a step is {robot.dt:g} s · '
        f"{len(scene.regions)} regions</div></div>"
    )
