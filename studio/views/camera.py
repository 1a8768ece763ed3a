"""The first view of a robot's workspace, for clients that come and for those that are there."""

from typing import Any

import viser

from studio.session import Session
from studio.views.bodies import BODIES, Camera


class CameraView:
    """Frames the workspace when another robot comes on stage; else the camera is the client's."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._robot = ""

    def draw(self, session: Session) -> None:
        """Follow the robot."""
        robot = session.document.scene.robot
        if robot == self._robot:
            return
        first, self._robot = not self._robot, robot
        camera = BODIES[robot].stage.camera
        _aim(self._server.initial_camera, camera)
        for client in () if first else self._server.get_clients().values():
            with client.atomic():
                _aim(client.camera, camera)


def _aim(handle: Any, camera: Camera) -> None:
    """Set the position first: the library moves the point looked at along with it."""
    handle.fov = camera.fov
    handle.position = camera.position
    handle.look_at = camera.look_at
