"""The initial view of a robot's workspace, for new and for connected clients."""

from typing import Any

import viser

from envs import Robot
from scenes import robot_of
from studio.page.session import Session
from studio.page.views.bodies import Camera, body_of


class CameraView:
    """Frames the workspace when the robot changes; otherwise the client controls the camera."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._robot: Robot | None = None

    def draw(self, session: Session) -> None:
        """Follow the robot."""
        robot = robot_of(session.document.scene)
        if robot == self._robot:
            return
        first, self._robot = self._robot is None, robot
        camera = body_of(robot).stage.camera
        _aim(self._server.initial_camera, camera)
        for client in () if first else self._server.get_clients().values():
            with client.atomic():
                _aim(client.camera, camera)


def _aim(handle: Any, camera: Camera) -> None:
    """Set the position first: the library moves the look-at point along with it."""
    handle.fov = camera.fov
    handle.position = camera.position
    handle.look_at = camera.look_at
