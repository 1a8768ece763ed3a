"""What is being edited: the selected region's outline and handles, and the region being drawn.

Dots resize the region. In 3D, arrows beyond the faces move it along an axis.
"""

from collections.abc import Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np
import trimesh
import viser

from core.decompose import Decomposition
from scenes import Region
from studio.page.editing.editor import Phase, Point
from studio.page.editing.shapes import axis_of, half_extents, handles
from studio.page.session import Session
from studio.page.views.outlines import outline
from studio.page.views.pointer import on_axis_drag, on_level_drag
from studio.page.views.regions import HEIGHT, shown_step
from studio.page.views.roles import Role, roles
from studio.page.views.solids import seen
from studio.theme import BRAND

ABOVE = 0.04
"""Height of planar outlines above the body they surround [m]."""

HANDLE, GAP, ARROW = 0.12, 0.3, 0.75
"""Radius of a dot, gap between a face and its arrow, and the arrow's length, in robot lengths."""

PREVIEW = (247, 103, 7)
AXIS_COLORS = ((224, 49, 49), (47, 158, 68), (25, 113, 194))


class Grip(NamedTuple):
    """Something to drag: a dot, or an arrow along an axis."""

    position: tuple[float, float, float]
    arrow: int | None = None


class EditingView:
    """Nodes below `/edit`. Grips are kept while dragged: removing the node would end the drag."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene, self._server = server.scene, server
        self._selected: tuple[Region | None, Region | None, Decomposition | None] | None = None
        self._preview: Region | None = None
        self._corners: tuple[tuple[float, float], ...] = ()
        self._kinds: tuple = ()
        self._grips: list[viser.SceneNodeHandle] = []

    def draw(self, session: Session) -> None:
        """Follow the editor."""
        editor = session.editor
        region = editor.selected
        there = None if region is None else region.displaced(shown_step(session))
        selected = (region, there, session.specification.decomposition)
        if selected != self._selected:
            self._selected = selected
            with self._server.atomic():
                self._show_selected(session, region, there)
        if editor.corners != self._corners:
            self._corners = editor.corners
            self._show_corners(editor.corners, editor.unit)
        if editor.preview is not self._preview:
            self._preview = editor.preview
            self._line("/edit/preview", editor.preview, ABOVE, PREVIEW, 3.0)

    def _show_corners(self, corners: tuple[tuple[float, float], ...], unit: float) -> None:
        """A ring at each corner that was clicked, and the way from one to the next."""
        if not corners:
            self._scene.remove_by_name("/edit/corners")
            return
        rings = [outline(Region("corner", "circle", at, (HANDLE * unit,)), ABOVE) for at in corners]
        way = np.column_stack([np.array(corners), np.full(len(corners), ABOVE)])
        self._scene.add_line_segments(
            "/edit/corners",
            np.concatenate([*rings, np.stack([way[:-1], way[1:]], 1)]).astype(np.float32),
            PREVIEW,
            thickness=3.0,
            thickness_units="screen",
        )

    def _show_selected(self, session: Session, region: Region | None, there: Region | None) -> None:
        """The outline of a region where it is; its grips where it begins, if it is there."""
        height = ABOVE + _body_height(session)
        unit = session.editor.unit
        surrounded = None if there is None else seen(there, unit)
        self._line("/edit/outline", surrounded, height, BRAND, 4.0)
        away = region is None or there is None or region.center != there.center
        shown = [] if region is None or away else grips(region, height, unit)
        turned = region is not None and region.angle != 0
        planar = region is None or region.dimension == 2
        kinds = (unit, planar, turned, [grip.arrow for grip in shown])
        if kinds != self._kinds:
            self._kinds = kinds
            self._make_grips(session, shown, planar=planar, turned=turned)
        for node, grip in zip(self._grips, shown, strict=True):
            node.position = grip.position

    def _make_grips(
        self, session: Session, wanted: Sequence[Grip], *, planar: bool, turned: bool
    ) -> None:
        for node in self._grips:
            node.remove()
        self._grips = []
        for index, grip in enumerate(wanted):
            if grip.arrow is not None:
                node = self._add_arrow(f"/edit/arrow{grip.arrow}", grip, session.editor.unit)
                on_axis_drag(node, partial(_move, session), grip.arrow)
            else:
                node = self._scene.add_icosphere(
                    f"/edit/handle{index}",
                    HANDLE * session.editor.unit,
                    BRAND,
                    position=grip.position,
                    cast_shadow=False,
                )
                drag = partial(_resize, session, index)
                if planar or (turned and axis_of(index) < 2):
                    on_level_drag(node, drag)
                else:
                    on_axis_drag(node, drag, axis_of(index))
            self._grips.append(node)

    def _add_arrow(self, name: str, grip: Grip, unit: float) -> viser.MeshHandle:
        axis = grip.arrow or 0
        mesh = arrow(axis)
        return self._scene.add_mesh_simple(
            name,
            mesh.vertices * unit,
            mesh.faces,
            color=AXIS_COLORS[axis],
            position=grip.position,
            cast_shadow=False,
            receive_shadow=False,
        )

    def _line(  # noqa: PLR0913
        self,
        name: str,
        region: Region | None,
        height: float,
        color: tuple[int, int, int],
        width: float,
    ) -> None:
        if region is None:
            self._scene.remove_by_name(name)
            return
        self._scene.add_line_segments(
            name,
            outline(region, height).astype(np.float32),
            color,
            thickness=width,
            thickness_units="screen",
        )


def grips(region: Region, height: float, unit: float) -> list[Grip]:
    """Dots of a region; in 3D, also arrows, placed outside the region and its dots."""
    dots = [Grip(_raised(point, height)) for point in handles(region)]
    if region.dimension == 2:
        return dots
    center = np.asarray(region.center)
    arrows = []
    for axis, half in enumerate(half_extents(region)):
        away = np.eye(3)[axis] * (half + GAP * unit)
        arrows.append(Grip(_raised(tuple(center + away), height), axis))
    return [*dots, *arrows]


@cache
def arrow(axis: int) -> trimesh.Trimesh:
    """An arrow along an axis from the origin, for a robot of length 1."""
    shaft, tip = 0.55 * ARROW, 0.45 * ARROW
    parts = (
        trimesh.creation.cylinder(0.05, shaft).apply_translation([0, 0, shaft / 2]),
        trimesh.creation.cone(0.13, tip).apply_translation([0, 0, shaft]),
    )
    mesh = trimesh.util.concatenate(parts)
    turn = trimesh.geometry.align_vectors([0, 0, 1], np.eye(3)[axis])
    return mesh.apply_transform(turn)


def _resize(session: Session, index: int, phase: Phase, start: Point, end: Point) -> None:
    del start
    session.post(lambda: session.editor.resize(index, phase, end))


def _move(session: Session, phase: Phase, start: Point, end: Point) -> None:
    def move() -> None:
        if session.editor.selection is not None:
            session.editor.move(session.editor.selection, phase, start, end)

    session.post(move)


def _body_height(session: Session) -> float:
    """Of the selected region, if it is planar [m]."""
    names = session.document.scene.region_names
    found = roles(names, session.specification.decomposition)
    return HEIGHT[found.get(session.editor.selection or "", Role.UNUSED)]


def _raised(point: tuple[float, ...], height: float) -> tuple[float, float, float]:
    x, y, z = (*point, height)[:3]
    return float(x), float(y), float(z)
