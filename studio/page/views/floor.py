"""The floor: where the robot may go, and where regions are drawn."""

from functools import partial

import numpy as np
import viser

from studio.page.editing.editor import CLICKED, SELECT
from studio.page.session import Session
from studio.page.views.bodies import Stage, stage_of
from studio.page.views.pointer import Dragged, level_point, on_level_drag

RIM_WIDTH, RIM_HEIGHT = 0.16, 0.22  # [m]


class FloorView:
    """A drag draws a region: with Shift always, without it while a drawing tool is active.

    With the select tool, a drag on the floor moves the camera.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._drawn: tuple[Stage, bool, bool] | None = None

    def draw(self, session: Session) -> None:
        """Follow the arena and the tool."""
        tool = session.editor.tool
        current = stage_of(session.document.scene), tool != SELECT, tool in CLICKED
        if current == self._drawn:
            return
        self._drawn = current
        stage, drawing, clicked = current
        (left, right), (front, back) = stage.floor
        width, depth = right - left, back - front
        middle = ((left + right) / 2, (front + back) / 2)
        floor = self._scene.add_box(
            "/floor",
            stage.color,
            (width, depth, stage.thickness),
            position=(*middle, -stage.thickness / 2 - 0.001),
            cast_shadow=False,
        )
        draw = drawing_drag(session)
        on_level_drag(floor, draw, height=0.0, modifier="shift")
        if drawing:
            on_level_drag(floor, draw, height=0.0)
        if clicked:

            @floor.on_click
            async def _(event: viser.SceneNodePointerEvent) -> None:
                click_corner(session, event)

        self._add_rim(stage)
        # Not a child of the floor: the upright grid would pass its clicks on to the floor.
        self._scene.add_grid(
            "/grid",
            width,
            depth,
            cell_size=stage.cell,
            section_size=5 * stage.cell,
            cell_color=stage.grid,
            section_color=stage.grid,
            shadow_opacity=0.0,
            position=(*middle, 0.002),
        )

    def _add_rim(self, stage: Stage) -> None:
        """Add four beams along the floor's edges."""
        self._scene.remove_by_name("/rim")
        if stage.rim is None:
            return
        (left, right), (front, back) = stage.floor
        width, depth, half = right - left, back - front, RIM_WIDTH / 2
        x, y = (left + right) / 2, (front + back) / 2
        for index, (size, place) in enumerate(
            (
                ((width, RIM_WIDTH), (x, front + half)),
                ((width, RIM_WIDTH), (x, back - half)),
                ((RIM_WIDTH, depth - 2 * RIM_WIDTH), (left + half, y)),
                ((RIM_WIDTH, depth - 2 * RIM_WIDTH), (right - half, y)),
            )
        ):
            self._scene.add_box(
                f"/rim/beam{index}",
                stage.rim,
                (*size, RIM_HEIGHT),
                position=(*place, RIM_HEIGHT / 2),
            )


def click_corner(session: Session, event: viser.SceneNodePointerEvent) -> None:
    """A click adds a corner to the polygon being drawn, where its ray meets the floor."""
    if event.ray_origin is not None and event.ray_direction is not None:
        origin = np.asarray(event.ray_origin, float)
        point = level_point(origin, origin + np.asarray(event.ray_direction, float), 0.0)
        session.post(partial(session.editor.corner, point))


def drawing_drag(session: Session) -> Dragged:
    """A drag that draws a region."""
    return lambda phase, start, end: session.post(partial(session.editor.draw, phase, start, end))
