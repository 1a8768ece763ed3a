"""What is being edited: the selected region's outline and handles, and the region being drawn.

Dots resize the region, the orange one on a stem turns it. Small dots on the edges of a polygon are
dragged out to new corners. In 3D, arrows beyond the faces move the region along an axis.
"""

from collections.abc import Sequence
from functools import cache, partial
from typing import Literal, NamedTuple

import numpy as np
import trimesh
import viser

from scenes import Region
from studio.page.editing.corners import middles_of
from studio.page.editing.editor import Editor, Phase, Point
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

SMALL = 0.6
"""Radius of the dots on edges, in that of the others."""

PREVIEW = CHOSEN = (247, 103, 7)
PALE = (143, 176, 200)
AXIS_COLORS = ((224, 49, 49), (47, 158, 68), (25, 113, 194))


NODE = {"dot": "handle", "corner": "handle", "edge": "edge", "turn": "turn", "arrow": "arrow"}
"""Names of the nodes of grips, without their numbers."""


class Grip(NamedTuple):
    """Something to drag."""

    position: tuple[float, float, float]
    kind: Literal["dot", "corner", "edge", "turn", "arrow"]
    index: int
    """Of the handle or edge; of an arrow, the axis."""
    axis: int | None = None
    """Along which it is dragged; None for a level."""


class EditingView:
    """Nodes below `/edit`. Grips are kept while dragged: removing the node would end the drag."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene, self._server = server.scene, server
        self._selected: tuple | None = None
        self._preview: Region | None = None
        self._corners: tuple[tuple[float, float], ...] = ()
        self._kinds: tuple = ()
        self._grips: list[viser.SceneNodeHandle] = []

    def draw(self, session: Session) -> None:
        """Follow the editor."""
        editor = session.editor
        region = editor.selected
        there = None if region is None else region.displaced(shown_step(session))
        held = (editor.vertex, editor.dragging, editor.turn_handle)
        selected = (region, there, session.specification.decomposition, held)
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
        shown = [] if away else shown_grips(session.editor, height)
        kinds = (unit, [(grip.kind, grip.axis) for grip in shown])
        if kinds != self._kinds:
            self._kinds = kinds
            self._make_grips(session, shown)
        self._stem(shown, region, height)
        for node, grip in zip(self._grips, shown, strict=True):
            node.position = grip.position
            if grip.kind == "corner" and isinstance(node, viser.IcosphereHandle):
                node.color = CHOSEN if grip.index == session.editor.vertex else BRAND

    def _stem(self, shown: Sequence[Grip], region: Region | None, height: float) -> None:
        """A line from the middle of what is turned to its handle."""
        handle = next((grip.position for grip in shown if grip.kind == "turn"), None)
        if handle is None or region is None:
            self._scene.remove_by_name("/edit/stem")
            return
        ends = np.array([[_raised(region.center, height), handle]], np.float32)
        self._scene.add_line_segments(
            "/edit/stem", ends, CHOSEN, thickness=2.0, thickness_units="screen"
        )

    def _make_grips(self, session: Session, wanted: Sequence[Grip]) -> None:
        for node in self._grips:
            node.remove()
        self._grips = [self._made(session, grip) for grip in wanted]

    def _made(self, session: Session, grip: Grip) -> viser.SceneNodeHandle:
        """The node of a grip, with what a drag of it does."""
        unit, name = session.editor.unit, f"/edit/{NODE[grip.kind]}{grip.index}"
        if grip.kind == "arrow":
            node = self._add_arrow(name, grip, unit)
            on_axis_drag(node, partial(_move, session), grip.index)
            return node
        small = SMALL if grip.kind == "edge" else 1.0
        color = {"turn": CHOSEN, "edge": PALE}.get(grip.kind, BRAND)
        node = self._scene.add_icosphere(
            name, small * HANDLE * unit, color, position=grip.position, cast_shadow=False
        )
        if grip.kind == "turn":
            on_level_drag(node, partial(_turn, session, False))
            on_level_drag(node, partial(_turn, session, True), modifier="shift")
            return node
        drag = partial(_add_corner if grip.kind == "edge" else _resize, session, grip.index)
        if grip.axis is None:
            on_level_drag(node, drag)
        else:
            on_axis_drag(node, drag, grip.axis)
        if grip.kind == "corner":

            @node.on_click
            async def _(_: viser.SceneNodePointerEvent) -> None:
                session.post(partial(_choose_corner, session, grip.index))

        return node

    def _add_arrow(self, name: str, grip: Grip, unit: float) -> viser.MeshHandle:
        axis = grip.index
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


def shown_grips(editor: Editor, height: float) -> list[Grip]:
    """Grips of what is selected; while a new corner is dragged, those there were before it."""
    region = editor.selected
    if region is None:
        return []
    edge, before = editor.adding, editor.grabbed
    if edge is None or before is None:
        shown = grips(region, height, editor.unit)
    else:
        shown = grips(before, height, editor.unit)
        if len(region.points) > len(before.points):
            held = _raised((*region.points[edge + 1], *region.center[2:]), height)
            at = next(i for i, g in enumerate(shown) if g.kind == "edge" and g.index == edge)
            shown[at] = shown[at]._replace(position=held)
    handle = editor.turn_handle
    if handle is not None:
        shown.append(Grip(_raised(handle, height), "turn", 0))
    return shown


def grips(region: Region, height: float, unit: float) -> list[Grip]:
    """Dots of a region; in 3D, also arrows, placed outside the region and its dots."""
    corners = len(region.points)
    dots = [
        Grip(
            _raised(point, height),
            "corner" if index < corners else "dot",
            index,
            axis_of(region, index),
        )
        for index, point in enumerate(handles(region))
    ]
    dots += [
        Grip(_raised(point, height), "edge", index)
        for index, point in enumerate(middles_of(region))
    ]
    if region.dimension == 2:
        return dots
    center = np.asarray(region.center)
    arrows = []
    for axis, half in enumerate(half_extents(region)):
        away = np.eye(3)[axis] * (half + GAP * unit)
        arrows.append(Grip(_raised(tuple(center + away), height), "arrow", axis, axis))
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


def _add_corner(session: Session, edge: int, phase: Phase, start: Point, end: Point) -> None:
    del start
    session.post(lambda: session.editor.add_corner(edge, phase, end))


def _choose_corner(session: Session, index: int) -> None:
    session.editor.vertex = index
    session.editor.check_selection()


def _turn(session: Session, fine: bool, phase: Phase, start: Point, end: Point) -> None:
    point = start if phase == "start" else end
    session.post(lambda: session.editor.turn(phase, point, fine=fine))


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
