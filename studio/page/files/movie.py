"""A rollout as one self-contained HTML file: the viewer's own player with the scene in it."""

from types import SimpleNamespace
from typing import Any, cast

from core.errors import UserError
from studio.page.server.quiet import quiet
from studio.page.server.security import LARGEST_PORT, is_free, start_server
from studio.page.session import Session
from studio.page.views.camera import CameraView
from studio.page.views.floor import FloorView
from studio.page.views.frame import FrameView
from studio.page.views.paths import PathsView
from studio.page.views.regions import RegionsView
from studio.page.views.robot import RobotView
from studio.runs.recording import Recording

SPEED = 4.0
"""Playback speed, relative to real time."""

FRAME = 1 / 20
"""Time between two frames of the file [s]."""

HOST, FIRST_PORT = "127.0.0.1", 20_000


def rollout_html(session: Session, recording: Recording) -> bytes:
    """Record the scene and the robot along a rollout.

    A second, hidden server draws it, so that the page does not change.

    Raises:
        UserError: no port is free for the second server.
    """
    with quiet():  # one recording at a time chooses its port
        port = next((p for p in range(FIRST_PORT, LARGEST_PORT) if is_free(HOST, p)), None)
        if port is None:
            raise UserError("The recording needs a free port on this machine, but there is none.")
        server = start_server(HOST, port, "recording")
    try:
        for view in (CameraView(server), FloorView(server), PathsView(server)):
            view.draw(session)
        moving = FrameView(server), RegionsView(server), RobotView(server)
        player = SimpleNamespace(recording=recording, position=0.0)
        shown = cast(
            Any,
            SimpleNamespace(
                player=player,
                document=session.document,
                specification=session.specification,
                analyst=session.analyst,
                hand=SimpleNamespace(held=None),
            ),
        )
        for view in moving:
            view.draw(shown)
        serializer = server.get_scene_serializer()
        step = FRAME * SPEED / recording.task.robot.dt
        for frame in range(int(recording.steps / step) + 2):
            player.position = min(frame * step, float(recording.steps))
            for view in moving:
                view.draw(shown)
            serializer.insert_sleep(FRAME)
        return serializer.as_html().encode()
    finally:
        with quiet():
            server.stop()
