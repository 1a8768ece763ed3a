"""The robot at the playhead, its trail and the path ahead."""

from collections.abc import Mapping

import numpy as np
import viser

from core.task.protocols import Robot as LearningRobot
from envs import Robot
from scenes import robot_of
from studio.page.session import Session
from studio.page.views.bodies import Body, Pose, body_of
from studio.page.views.bodies.body import ROOT
from studio.page.views.solids import settle
from studio.runs.recording import Recording
from studio.runs.tasks import initial_state
from studio.theme import TRAIL

WAY, WAY_WIDTH, TRAIL_WIDTH = (206, 212, 218), 0.04, 0.08
"""Widths in robot lengths."""

WAY_LIFT, TRAIL_LIFT, IN_SPACE = 0.03, 0.08, 0.045
"""Heights that separate overlapping lines, in robot lengths: above the floor for planar robots,
lower by `IN_SPACE` for others."""

DROP, DROP_WIDTH = (134, 142, 150), 0.03


class RobotView:
    """Follows the playhead; without a rollout, the robot is shown in the initial set."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._robot: Robot | None = None
        self._parts: Mapping[str, viser.SceneNodeHandle] = {}
        self._lines: dict[str, viser.LineSegmentsHandle] = {}
        self._recording: Recording | None = None
        self._track = np.zeros((0, 0))
        self._drawn: tuple | None = None

    def draw(self, session: Session) -> None:
        """Move robot and trail to the playhead."""
        player, task = session.player, session.specification.task
        recording, position = player.recording, player.position
        robot = robot_of(session.specification.scene)
        start = session.analyst.start
        held = session.hand.held
        current = (robot, recording, position, None if recording else task, start, held)
        if current == self._drawn:
            return
        self._drawn = current
        body = body_of(robot)
        with self._server.atomic():
            self._show_robot(robot, body)
            if recording is not self._recording:
                self._load(robot, body, recording)
            if recording is not None:
                here = between(recording.positions, position)
                row = between(self._track, position)
                if held is not None and held.recording is recording:
                    here, row = held.position, held.state
                self._place(body.poses(row))
                self._extend(recording, position)
                self._drop(robot, here)
            elif task is not None:
                state = initial_state(task, start)
                self._place(body.poses(np.asarray(state)))
                self._drop(robot, np.asarray(task.robot.position(state)))

    def _show_robot(self, robot: Robot, body: Body) -> None:
        if robot == self._robot:
            return
        self._robot = robot
        scene = self._server.scene
        scene.remove_by_name("/robot")
        root = scene.add_frame("/robot", show_axes=False)
        self._parts = {ROOT: root, **body.build(scene, "/robot")}
        for part in self._parts.values():
            settle(part)

    def _place(self, poses: Mapping[str, Pose]) -> None:
        for name, pose in poses.items():
            part = self._parts[name]
            part.position, part.wxyz = pose.position, pose.wxyz

    def _load(self, robot: Robot, body: Body, recording: Recording | None) -> None:
        self._recording = recording
        for line in self._lines.values():
            line.remove()
        self._lines = {}
        if recording is None:
            return
        self._track = body.track(recording.states, recording.actions)
        for name, color, width in (
            ("/path", WAY, WAY_WIDTH),
            ("/trail", TRAIL, TRAIL_WIDTH),
        ):
            self._lines[name] = self._server.scene.add_line_segments(
                name, np.zeros((1, 2, 3), np.float32), color, thickness=width * robot.length
            )

    def _extend(self, recording: Recording, position: float) -> None:
        """Split the path at the playhead into the trail and the path ahead."""
        here = between(recording.positions, position)[None]
        low = min(int(position), recording.steps)
        done = np.concatenate([recording.positions[: low + 1], here])
        ahead = np.concatenate([here, recording.positions[low + 1 :]])
        robot = recording.task.robot
        self._lines["/trail"].points = segments(done, lifted(robot, TRAIL_LIFT))
        self._lines["/path"].visible = len(ahead) > 1
        if len(ahead) > 1:
            self._lines["/path"].points = segments(ahead, lifted(robot, WAY_LIFT))

    def _drop(self, robot: Robot, here: np.ndarray) -> None:
        """A line from a robot in space to the ground below it, so that its height is seen."""
        if robot.position_size == 2:
            self._server.scene.remove_by_name("/drop")
            return
        ground = here * np.array([1.0, 1.0, 0.0])
        self._server.scene.add_line_segments(
            "/drop",
            np.stack([here, ground])[None].astype(np.float32),
            DROP,
            thickness=DROP_WIDTH * robot.length,
        )


def between(rows: np.ndarray, position: float) -> np.ndarray:
    """Row [k] of a table [T + 1, k] at a position between two steps."""
    last = len(rows) - 1
    low = min(int(position), last)
    high, part = min(low + 1, last), position - low
    return rows[low] * (1 - part) + rows[high] * part


def lifted(robot: LearningRobot, lengths: float) -> float:
    """Height of a line above a robot's positions [m], from a height in robot lengths."""
    return (lengths if robot.position_size == 2 else lengths - IN_SPACE) * robot.length


def segments(points: np.ndarray, height: float) -> np.ndarray:
    """Segments [N - 1, 2, 3] between consecutive points [N, 3], raised by a height [m]."""
    raised = (points + np.array([0.0, 0.0, height])).astype(np.float32)
    return np.stack([raised[:-1], raised[1:]], axis=1)
