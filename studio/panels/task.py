"""The choice of a task, and what it is about."""

from functools import partial

import viser

from envs import ENVS
from scenes import Scene, demo_names, task_names
from studio.figures.svg import escape
from studio.panels.html import Html
from studio.session import Session


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

        @self._menu.on_update
        async def _(event: viser.GuiEvent) -> None:
            if event.client_id is not None:
                session.post(partial(self._choose, session, event.target.value))

    def draw(self, session: Session) -> None:
        """Show the scene."""
        scene = session.specification.scene
        self._menu.value = scene.name
        self._about.show(_about(scene))

    def _choose(self, session: Session, name: str) -> None:
        if name == self._opened.name:
            session.open(self._opened)
        else:
            session.choose_task(name)


def _about(scene: Scene) -> str:
    robot = ENVS[scene.robot]
    return (
        f'<div class="tg"><div class="tg-title">{escape(scene.title)}</div>'
        f'<div class="tg-dim">{escape(robot.name.capitalize())} robot · a step is {robot.dt:g} s · '
        f"{len(scene.regions)} regions</div></div>"
    )
