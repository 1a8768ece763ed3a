"""The camera follows the robot; each client keeps its own viewing direction."""

import numpy as np
import viser

from studio.page.session import Session
from studio.page.views.robot import between

NEARER = 0.25
"""How far short of the robot the camera looks, as a share of its distance, clear of the panel."""

LEAST = 0.03
"""Movement of the robot after which the camera is moved, in robot lengths."""


class FollowView:
    """Moves the cameras as the robot moves, while `Session.following`."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._last: np.ndarray | None = None

    def draw(self, session: Session) -> None:
        """Follow the playhead."""
        player = session.player
        if not session.following or player.recording is None:
            self._last = None
            return
        here = between(player.recording.positions, player.position)
        clients = self._server.get_clients().values()
        if self._last is None:
            moves = [_centring(here, client.camera) for client in clients]
        else:
            moves = [here - self._last] * len(clients)
            if (
                np.linalg.norm(moves[0] if moves else 0)
                < LEAST * player.recording.task.robot.length
            ):
                return
        self._last = here
        for client, move in zip(clients, moves, strict=True):
            # The library moves the look-at point along with the position.
            client.camera.position = np.asarray(client.camera.position, float) + move


def _centring(here: np.ndarray, camera: viser.CameraHandle) -> np.ndarray:
    """Movement that brings the robot into the free upper part of the picture."""
    target = np.asarray(camera.look_at, float)
    towards = (np.asarray(camera.position, float) - target) * np.array([1.0, 1.0, 0.0])
    return here + NEARER * towards - target
