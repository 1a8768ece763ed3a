"""The page: one server, one session, panels and views, and the loop that draws them."""

import os
import sys
import threading
import time
import traceback
import webbrowser
from functools import partial
from pathlib import Path
from typing import Protocol

import viser

from core.errors import UserError
from core.methods import METHODS
from core.methods.training import TrainingConfig
from scenes import Scene, load_scene, load_task, robot_of
from studio.page.commands import add_commands
from studio.page.files.keeping import load_policy
from studio.page.files.projects import state_folder
from studio.page.files.shelf import Shelf
from studio.page.panels.formula import FormulaPanel
from studio.page.panels.ghosts import GhostsPanel
from studio.page.panels.heatmap import HeatmapPanel
from studio.page.panels.keep import KeepPanel
from studio.page.panels.mission import MissionFields
from studio.page.panels.monitor import MonitorPanel, PlayheadStyle
from studio.page.panels.recovery import RecoveryPanel
from studio.page.panels.regions import RegionsPanel
from studio.page.panels.rollout import RolloutPanel
from studio.page.panels.task import TaskPanel
from studio.page.panels.tour import TourPanel, add_page_options, set_theme
from studio.page.panels.training import TrainingPanel
from studio.page.panels.tree import TreePanel
from studio.page.playback import add_playback_commands
from studio.page.server.quiet import quiet
from studio.page.server.security import chosen_token, start_server
from studio.page.session import MakeConfig, Session
from studio.page.views.camera import CameraView
from studio.page.views.editing import EditingView
from studio.page.views.floor import FloorView
from studio.page.views.follow import FollowView
from studio.page.views.frame import FrameView
from studio.page.views.ghosts import GhostsView
from studio.page.views.grip import GripView
from studio.page.views.highlight import HighlightView
from studio.page.views.paths import PathsView
from studio.page.views.regions import RegionsView
from studio.page.views.robot import RobotView
from studio.page.views.start import StartView
from studio.theme import STYLE

FIRST_TASK = "panda-demo"
FRAME = 1 / 25
"""Least time between two drawings [s]."""
IDLE = 1 / 5
"""The same while no client is connected, to leave the processor to the training [s]."""


class Drawable(Protocol):
    """A panel or a view: shows the session without changing it."""

    def draw(self, session: Session) -> None:
        """Update what is shown; cheap where nothing has changed."""
        ...


class Studio:
    """A running page. `run` draws until `close`."""

    def __init__(
        self,
        scene: Scene,
        formula: str | None,
        host: str,
        port: int,
        make_config: MakeConfig | None = None,
        *,
        state: Path | None = None,
        token: str = "",
    ) -> None:
        """Start serving.

        Args:
            scene: shown first.
            formula: shown in the editor instead of the scene's own.
            host: where to listen.
            port: where to listen.
            make_config: makes the training that the button starts.
            state: folder for autosave and the like; None keeps nothing.
            token: that clients must present; empty on a loopback address.
        """
        self.url = f"http://{'[' + host + ']' if ':' in host else host}:{port}"
        if token:
            self.url += f"/?token={token}"
        self._server = start_server(host, port, "TGPO Studio", token)
        self.session = Session(scene, formula, make_config or default_config)
        self._recovery: RecoveryPanel | None = None
        gui, seen = self._server.gui, None
        if state is not None:
            self._recovery, seen = RecoveryPanel(gui, self.session, state / "autosave"), state
        self._drawables: list[Drawable] = [] if self._recovery is None else [self._recovery]
        shelf = Shelf(None if state is None else state / "scenes")
        tour = TourPanel(gui, self.session, None if seen is None else seen / "tour-seen")
        self._drawables += [tour, *_build(self._server, self.session, shelf)]
        add_page_options(gui, self.session, tour)
        self._closed = threading.Event()

    def run(self) -> None:
        """Draw frames until closed."""
        while not self._closed.is_set():
            began = time.monotonic()
            self.session.news.clear()
            watched = bool(self._server.get_clients())
            self.session.analyst.watched = watched
            self.session.tick(began)
            for drawable in self._drawables:
                self._draw(drawable)
            self.session.news.wait(
                max(0.0, began + (FRAME if watched else IDLE) - time.monotonic())
            )

    def _draw(self, drawable: Drawable) -> None:
        """Draw; an error in one panel is shown and does not stop the others."""
        try:
            drawable.draw(self.session)
        except Exception as error:  # noqa: BLE001
            text = f"{type(drawable).__name__}: {type(error).__name__}: {error}"
            if self.session.error != text:
                traceback.print_exc()
                self.session.error = text

    def close(self) -> bool:
        """Stop drawing, training and serving; whether all threads have ended."""
        self._closed.set()
        self.session.news.set()
        if self._recovery is not None:
            self._recovery.close()
        ended = self.session.close()
        with quiet():  # the library says so on stdout
            self._server.stop()
        return ended


def serve(
    *,
    task: str | None = None,
    scene: str | None = None,
    formula: str | None = None,
    host: str = "127.0.0.1",
    port: int = 8080,
    open_browser: bool = True,
    load: Path | None = None,
    token: str | None = None,
) -> None:
    """Serve the page until interrupted; the caller has set up the compilation cache.

    Args:
        task: a shipped task to open.
        scene: a scene file to open instead.
        formula: shown in the editor instead of the scene's own.
        host: a loopback address; any other address needs a token.
        port: where to listen; a port in use is an error.
        open_browser: whether to open a browser window.
        load: a run or a bundle (a folder or a zip file) to open instead.
        token: that clients must present; by default random if the address needs one.

    Raises:
        UserError: an unknown task, a bad scene file, or an address that cannot be used.
    """
    policy = None if load is None else load_policy(load)
    first = opened_scene(task, scene) if policy is None else policy.scene
    secret = chosen_token(host, token)
    studio = Studio(first, formula, host, port, state=state_folder(), token=secret)
    if policy is not None:
        studio.session.post(partial(studio.session.load, policy, f"the policy in {load}"))
    print(f"TGPO Studio is running at {studio.url}  (Ctrl+C to stop)", flush=True)
    if open_browser:
        threading.Thread(target=webbrowser.open, args=(studio.url,), daemon=True).start()
    try:
        studio.run()
    except KeyboardInterrupt:
        print("\nStopped.")
    finally:
        ended = studio.close()
    if not ended:
        # A thread may compile for tens of seconds more; the interpreter would wait for it.
        sys.stdout.flush()
        os._exit(0)


def opened_scene(task: str | None, scene: str | None) -> Scene:
    """The scene that the arguments ask for."""
    if task is not None and scene is not None:
        raise UserError(f"give a task ({task!r}) or a scene file ({scene!r}), not both")
    if scene is not None:
        return load_scene(Path(scene))
    return load_task(task if task is not None else FIRST_TASK)


def default_config(scene: Scene, time_limit: float) -> TrainingConfig:
    """TGPO* in studio mode."""
    algorithm = METHODS["tgpo-star"].preset("studio", robot_of(scene))
    return TrainingConfig(algorithm, seed=scene.seed, epochs=1000, time_limit=time_limit)


def _build(server: viser.ViserServer, session: Session, shelf: Shelf) -> list[Drawable]:
    """Lay out the page: the task on the left, learning on the right, the robot in between."""
    gui = server.gui
    set_theme(gui, dark=False)
    gui.add_html(STYLE)
    add_commands(gui, session)
    add_playback_commands(gui, session)
    drawables: list[Drawable] = [
        PlayheadStyle(gui),
        TaskPanel(gui, session, shelf),
        MissionFields(gui, session),
        RegionsPanel(gui, session),
        FormulaPanel(gui, session),
        TreePanel(gui, session),
    ]
    learning = gui.add_panel()
    with learning.add_tab("Learning", viser.Icon.BRAIN):
        drawables += [TrainingPanel(gui, session), HeatmapPanel(gui, session)]
    with learning.add_tab("Files", viser.Icon.DEVICE_FLOPPY):
        drawables.append(KeepPanel(gui, session, shelf))
    rollout = gui.add_panel()
    with rollout.add_tab("Rollout", viser.Icon.ROUTE):
        drawables += [RolloutPanel(gui, session), GhostsPanel(gui, session)]
    with rollout.add_tab("Monitor", viser.Icon.TABLE):
        drawables.append(MonitorPanel(gui, session))
    gui.main_panel.dock_left()
    gui.main_panel.set_width(400)
    learning.dock_right()
    learning.set_width(420)
    rollout.float(x=20, y=-14, width=580)
    views: list[Drawable] = [
        CameraView(server),
        RegionsView(server),
        PathsView(server),
        FrameView(server),
        HighlightView(server),
        GhostsView(server),
        RobotView(server),
    ]
    views += [GripView(server), StartView(server), FollowView(server)]
    # The floor first: a tool works before its button looks pressed.
    return [FloorView(server), *drawables, *views, EditingView(server)]
