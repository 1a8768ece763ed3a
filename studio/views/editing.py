"""What is being edited: the selected region's outline and handles, and the region being drawn."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import viser

from core.decompose import Decomposition
from scenes import Region
from studio.editing.shapes import handles
from studio.session import Session
from studio.theme import BRAND
from studio.views.outlines import outline
from studio.views.pointer import on_free_drag, on_level_drag
from studio.views.regions import HEIGHT
from studio.views.roles import Role, roles

ABOVE = 0.04
"""Height of planar outlines above the body that they surround [m]."""

HANDLE = 0.12
"""Radius of a handle [m]."""
PREVIEW = (247, 103, 7)


class EditingView:
    """Nodes below `/edit`. Handles stay while they are dragged: without its node a drag ends."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene, self._server = server.scene, server
        self._selected: tuple[Region | None, Decomposition | None] | None = None
        self._preview: Region | None = None
        self._handles: list[viser.IcosphereHandle] = []

    def draw(self, session: Session) -> None:
        """Follow the editor."""
        editor = session.editor
        selected = (editor.selected, session.specification.decomposition)
        if selected != self._selected:
            self._selected = selected
            with self._server.atomic():
                self._show_selected(session, editor.selected)
        if editor.preview is not self._preview:
            self._preview = editor.preview
            self._line("/edit/preview", editor.preview, ABOVE, PREVIEW, 3.0)

    def _show_selected(self, session: Session, region: Region | None) -> None:
        height = ABOVE + _body_height(session)
        self._line("/edit/outline", region, height, BRAND, 4.0)
        points = [] if region is None else [_raised(point, height) for point in handles(region)]
        if len(points) != len(self._handles):
            self._make_handles(session, points, planar=region is None or region.dimension == 2)
        for handle, point in zip(self._handles, points, strict=True):
            handle.position = point

    def _make_handles(
        self, session: Session, points: Sequence[tuple[float, float, float]], *, planar: bool
    ) -> None:
        for handle in self._handles:
            handle.remove()
        self._handles = []
        for index, point in enumerate(points):
            node = self._scene.add_icosphere(
                f"/edit/handle{index}",
                HANDLE,
                BRAND,
                position=point,
                cast_shadow=False,
            )
            drag = partial(_resize, session, index)
            (on_level_drag if planar else on_free_drag)(node, drag)
            self._handles.append(node)

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


def _resize(session: Session, index: int, phase, start, end) -> None:
    session.post(lambda: session.editor.resize(index, phase, end))


def _body_height(session: Session) -> float:
    """Of the selected region, if it is planar [m]."""
    names = session.document.scene.region_names
    found = roles(names, session.specification.decomposition)
    return HEIGHT[found.get(session.editor.selection or "", Role.UNUSED)]


def _raised(point: tuple[float, ...], height: float) -> tuple[float, float, float]:
    x, y, z = (*point, height)[:3]
    return x, y, z
