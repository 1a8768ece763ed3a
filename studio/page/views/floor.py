"""The floor: where the robot may go, and where regions are drawn."""

from collections.abc import Callable
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
        self._floor: viser.BoxHandle | None = None
        self._stage: Stage | None = None
        self._tool = SELECT
        self._unbind: list[Callable[[], None]] = []
        """Undo what the tool has bound to the floor."""

    def draw(self, session: Session) -> None:
        """Follow the arena and the tool.

        Another tool is bound to the floor that is there: a new floor would miss a drag that begins
        before the browser has it.
        """
        stage, tool = stage_of(session.document.scene), session.editor.tool
        if self._floor is None or stage != self._stage:
            self._floor, self._stage, self._tool = self._add_floor(stage), stage, SELECT
            self._unbind.clear()
            on_level_drag(self._floor, drawing_drag(session), height=0.0, modifier="shift")
        if tool != self._tool:
            self._tool = tool
            self._bind(self._floor, session)

    def _bind(self, floor: viser.BoxHandle, session: Session) -> None:
        """Bind the tool to the floor, in place of the one before."""
        for undo in self._unbind:
            undo()
        self._unbind.clear()
        if self._tool == SELECT:
            return
        drag = on_level_drag(floor, drawing_drag(session), height=0.0)
        self._unbind.append(partial(floor.remove_drag_callback, drag))
        if self._tool in CLICKED:

            @floor.on_click
            async def click(event: viser.SceneNodePointerEvent) -> None:
                click_corner(session, event)

            self._unbind.append(partial(floor.remove_click_callback, click))

    def _add_floor(self, stage: Stage) -> viser.BoxHandle:
        """Add floor, rim and grid."""
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
        return floor

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
