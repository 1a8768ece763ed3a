"""Highlighted regions: a bright outline in 2D, a shell in 3D, the edges of a wall."""

import numpy as np
import viser

from scenes import Region, Scene
from studio.page.session import Session
from studio.page.views.outlines import outline
from studio.page.views.regions import HEIGHT, shown_step
from studio.page.views.roles import roles
from studio.page.views.solids import add_solid
from studio.page.views.walls import Face, face_edges, wall_faces

BRIGHT = (255, 183, 3)
LIFT, THICKNESS = 0.04, 0.1
"""Of the outline of a planar region: height above its body, and width [m]."""
GROWTH, OPACITY = 1.06, 0.45
"""Of the shell around a region in 3D."""


class HighlightView:
    """Draws `Session.highlighted`."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._drawn: tuple[Scene | None, tuple[str, ...], float] = (None, (), 0.0)

    def draw(self, session: Session) -> None:
        """Redraw when other regions are highlighted."""
        scene, names = session.specification.scene, session.highlighted
        current = (scene, names, shown_step(session) if names else 0.0)
        if current == self._drawn:
            return
        self._drawn = current
        with self._server.atomic():
            self._server.scene.remove_by_name("/highlight")
            faces = wall_faces(scene)
            found = roles(scene.region_names, session.specification.decomposition)
            for index, region in enumerate(scene.regions):
                if region.name in names:
                    height = HEIGHT[found[region.name]] + LIFT
                    face = faces.get(region.name)
                    there = region.displaced(current[2])
                    self._outline(f"/highlight/region{index}", there, height, face)

    def _outline(self, name: str, region: Region, height: float, face: Face | None) -> None:
        scene = self._server.scene
        if face is not None:
            edges = face_edges(face).astype(np.float32)
            scene.add_line_segments(name, edges, BRIGHT, thickness=4.0, thickness_units="screen")
            return
        if region.dimension == 2:
            segments = outline(region, height).astype(np.float32)
            scene.add_line_segments(name, segments, BRIGHT, thickness=THICKNESS)
            return
        for number, piece in enumerate(region.pieces):
            shell = piece.sized(tuple(GROWTH * length for length in piece.size))
            add_solid(scene, f"{name}/{number}", shell, BRIGHT, height, OPACITY)
