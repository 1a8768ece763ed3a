"""A rollout as one self-contained HTML file: the viewer's own player with the scene in it."""

import io
from contextlib import redirect_stdout
from types import SimpleNamespace
from typing import Any, cast

from core.errors import UserError
from studio.playing.recording import Recording
from studio.server.security import LARGEST_PORT, is_free, start_server
from studio.session import Session
from studio.views.camera import CameraView
from studio.views.floor import FloorView
from studio.views.frame import FrameView
from studio.views.regions import RegionsView
from studio.views.robot import RobotView

SPEED = 4.0
"""Times faster than the robot."""

FRAME = 1 / 20
"""Between two frames of the file [s]."""

HOST, FIRST_PORT = "127.0.0.1", 20_000


def rollout_html(session: Session, recording: Recording) -> bytes:
    """Record the scene and the robot along a rollout.

    A second, hidden server draws it: what is on the page is not moved for it.

    Raises:
        UserError: no port is free for the second server.
    """
    port = next((p for p in range(FIRST_PORT, LARGEST_PORT) if is_free(HOST, p)), None)
    if port is None:
        raise UserError("The recording needs a free port on this machine; there is none.")
    server = start_server(HOST, port, "recording")
    try:
        for view in (CameraView(server), FloorView(server), FrameView(server), RegionsView(server)):
            view.draw(session)
        robot = RobotView(server)
        player = SimpleNamespace(recording=recording, position=0.0)
        shown = cast(
            Any,
            SimpleNamespace(
                player=player, specification=session.specification, analyst=session.analyst
            ),
        )
        robot.draw(shown)
        serializer = server.get_scene_serializer()
        step = FRAME * SPEED / recording.task.robot.dt
        for frame in range(int(recording.steps / step) + 2):
            player.position = min(frame * step, float(recording.steps))
            robot.draw(shown)
            serializer.insert_sleep(FRAME)
        return serializer.as_html().encode()
    finally:
        with redirect_stdout(io.StringIO()):
            server.stop()
