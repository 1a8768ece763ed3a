"""The floor: where the robot may go, and where regions are drawn."""

from functools import partial

import viser

from envs import ENVS
from studio.editing.editor import SELECT
from studio.session import Session
from studio.views.pointer import Dragged, on_level_drag

FLOOR, GRID = (247, 248, 250), (226, 229, 234)


class FloorView:
    """A drag draws a region: with Shift always, without while a tool for drawing is held.

    With the tool to select, a drag on the floor is the camera's.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._drawn: tuple[str, bool] | None = None

    def draw(self, session: Session) -> None:
        """Follow the robot's workspace and the tool."""
        current = session.document.scene.robot, session.editor.tool != SELECT
        if current == self._drawn:
            return
        self._drawn = current
        robot, drawing = current
        (left, right), (front, back) = ENVS[robot].workspace[:2]
        width, depth = right - left, back - front
        middle = ((left + right) / 2, (front + back) / 2)
        floor = self._scene.add_box(
            "/floor",
            FLOOR,
            (width, depth, 0.1),
            position=(*middle, -0.051),
            cast_shadow=False,
        )
        draw = drawing_drag(session)
        on_level_drag(floor, draw, height=0.0, modifier="shift")
        if drawing:
            on_level_drag(floor, draw, height=0.0)
        # Not below the floor: the grid would pass on clicks that hit it, standing upright.
        self._scene.add_grid(
            "/grid",
            width,
            depth,
            cell_size=1.0,
            section_size=5.0,
            cell_color=GRID,
            section_color=GRID,
            shadow_opacity=0.0,
            position=(*middle, 0.002),
        )


def drawing_drag(session: Session) -> Dragged:
    """A drag that draws a region."""
    return lambda phase, start, end: session.post(partial(session.editor.draw, phase, start, end))
