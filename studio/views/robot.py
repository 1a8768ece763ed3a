"""The robot at the playhead, and the trail behind it."""

import math

import numpy as np
import viser

from studio.analyst import initial_state
from studio.playing.recording import Recording
from studio.session import Session
from studio.theme import TRAIL
from studio.views.bodies import BODY, HEADING

LIFT = 0.05
"""Of the trail over the path, so that it covers it [m]."""


class RobotView:
    """Follows the playhead; without a rollout the robot waits in the initial set."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._robot = ""
        self._node: viser.FrameHandle | None = None
        self._path: viser.LineSegmentsHandle | None = None
        self._trail: viser.LineSegmentsHandle | None = None
        self._recording: Recording | None = None
        self._drawn: tuple | None = None

    def draw(self, session: Session) -> None:
        """Move robot and trail to where the playhead stands."""
        player, task = session.player, session.specification.task
        recording, position = player.recording, player.position
        robot = session.specification.scene.robot
        start = session.analyst.start
        current = (robot, recording, position, None if recording else task, start)
        if current == self._drawn:
            return
        self._drawn = current
        with self._server.atomic():
            self._show_robot(robot)
            if recording is not self._recording:
                self._load(recording)
            if recording is not None:
                self._place(robot, *interpolated(recording, position))
                self._extend(recording, position)
            elif task is not None:
                state = initial_state(task, start)
                position = np.asarray(task.robot.position(state))
                self._place(robot, np.asarray(state), _spatial(position))

    def _show_robot(self, robot: str) -> None:
        if robot == self._robot:
            return
        self._robot = robot
        scene = self._server.scene
        scene.remove_by_name("/robot")
        self._node = scene.add_frame("/robot", show_axes=False)
        BODY[robot](scene, "/robot")

    def _place(self, robot: str, state: np.ndarray, position: np.ndarray) -> None:
        if self._node is None:
            return
        heading = float(state[HEADING[robot]]) if robot in HEADING else 0.0
        self._node.position = position
        self._node.wxyz = np.array([math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)])

    def _load(self, recording: Recording | None) -> None:
        self._recording = recording
        for node in (self._path, self._trail):
            if node is not None:
                node.remove()
        self._path = self._trail = None
        if recording is None:
            return
        lines = segments(recording.positions, 0.03)
        self._path = self._server.scene.add_line_segments(
            "/path", lines, (206, 212, 218), thickness=0.04
        )
        self._trail = self._server.scene.add_line_segments(
            "/trail", lines[:1] + LIFT, TRAIL, thickness=0.08
        )

    def _extend(self, recording: Recording, position: float) -> None:
        if self._trail is None:
            return
        done = recording.positions[: int(position) + 1]
        here = interpolated(recording, position)[1]
        self._trail.points = segments(np.concatenate([done, here[None]]), 0.03 + LIFT)


def interpolated(recording: Recording, position: float) -> tuple[np.ndarray, np.ndarray]:
    """State [n] and position [3] between two steps."""
    low = min(int(position), recording.steps)
    high, part = min(low + 1, recording.steps), position - low
    return (
        recording.states[low] * (1 - part) + recording.states[high] * part,
        recording.positions[low] * (1 - part) + recording.positions[high] * part,
    )


def segments(points: np.ndarray, height: float) -> np.ndarray:
    """Segments [N - 1, 2, 3] between consecutive points [N, 3], raised by a height [m]."""
    lifted = (points + np.array([0.0, 0.0, height])).astype(np.float32)
    return np.stack([lifted[:-1], lifted[1:]], axis=1)


def _spatial(position: np.ndarray) -> np.ndarray:
    return np.concatenate([position, np.zeros(3)])[:3]
