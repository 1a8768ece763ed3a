"""The initial view of a robot's workspace, for new and for connected clients."""

from typing import Any

import viser

from envs import Robot
from scenes import robot_of, workspace_of
from scenes.arena import Arena
from studio.page.session import Session
from studio.page.views.bodies import Camera, stage_of


class CameraView:
    """Frames the arena when robot or arena change; otherwise the client controls the camera."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._framed: tuple[Robot, Arena] | None = None

    def draw(self, session: Session) -> None:
        """Follow the robot and its arena."""
        scene = session.document.scene
        framed = robot_of(scene), workspace_of(scene).arena
        if framed == self._framed:
            return
        first, self._framed = self._framed is None, framed
        camera = stage_of(scene).camera
        _aim(self._server.initial_camera, camera)
        for client in () if first else self._server.get_clients().values():
            with client.atomic():
                _aim(client.camera, camera)


def _aim(handle: Any, camera: Camera) -> None:
    """Set the position first: the library moves the look-at point along with it."""
    handle.fov = camera.fov
    handle.position = camera.position
    handle.look_at = camera.look_at
