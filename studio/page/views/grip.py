"""What the robot is taken by: a ball around it, and in space an arrow that lifts it."""

from functools import partial

import numpy as np
import viser

from envs import Robot
from scenes import robot_of
from studio.page.editing.editor import SELECT, Phase, Point
from studio.page.session import Session
from studio.page.views.editing import AXIS_COLORS, arrow
from studio.page.views.pointer import on_axis_drag, on_level_drag
from studio.page.views.robot import between
from studio.theme import BRAND

RADIUS, OPACITY = 0.4, 0.13
"""Radius in robot lengths; of a planar robot the ball stands half above the floor."""

UP = 2
"""The axis of the arrow."""


class GripView:
    """Nodes `/grip` and `/grip/up`, at the playhead while a rollout plays.

    They are kept while dragged: removing the node would end the drag.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._robot: Robot | None = None
        self._grip: viser.IcosphereHandle | None = None
        self._drawn: tuple | None = None

    def draw(self, session: Session) -> None:
        """Follow the robot; out of reach while something else is drawn or chosen."""
        recording, held = session.player.recording, session.hand.held
        busy = session.editor.tool != SELECT or session.choosing_start
        shown = held is not None or (session.hand.can_take() and not busy)
        current = (recording, session.player.position, held, shown)
        if current == self._drawn:
            return
        self._drawn = current
        robot = robot_of(session.specification.scene)
        if robot != self._robot or self._grip is None:
            self._robot = robot
            self._grip = self._made(session, robot)
        self._grip.visible = shown
        if shown and recording is not None:
            moving = between(recording.positions, session.player.position)
            self._grip.position = moving if held is None else held.position

    def _made(self, session: Session, robot: Robot) -> viser.IcosphereHandle:
        self._scene.remove_by_name("/grip")
        size = RADIUS * robot.length
        grip = self._scene.add_icosphere(
            "/grip", size, BRAND, opacity=OPACITY, cast_shadow=False, receive_shadow=False
        )
        drag = partial(_drag, session)
        on_level_drag(grip, drag)
        if robot.position_size > UP:
            mesh = arrow(UP)
            up = self._scene.add_mesh_simple(
                "/grip/up",
                mesh.vertices * robot.length + np.array([0.0, 0.0, size]),
                mesh.faces,
                color=AXIS_COLORS[UP],
                cast_shadow=False,
                receive_shadow=False,
            )
            on_axis_drag(up, drag, UP)
        return grip


def _drag(session: Session, phase: Phase, start: Point, end: Point) -> None:
    session.post(partial(session.hand.drag, phase, start, end))
