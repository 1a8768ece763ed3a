"""Regions pointed out: a bright outline around each."""

import numpy as np
import viser

from scenes import Region, Scene
from studio.session import Session
from studio.views.outlines import outline
from studio.views.regions import HEIGHT
from studio.views.roles import roles
from studio.views.solids import add_solid

BRIGHT = (255, 183, 3)
LIFT, THICKNESS = 0.04, 0.1
"""Of the outline of a planar region: over its body; and its width [m]."""
GROWTH, OPACITY = 1.06, 0.45
"""Of the shell around a region in space."""


class HighlightView:
    """Draws `Session.highlighted`."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._drawn: tuple[Scene | None, tuple[str, ...]] = (None, ())

    def draw(self, session: Session) -> None:
        """Redraw when other regions are pointed out."""
        scene, names = session.specification.scene, session.highlighted
        if (scene, names) == self._drawn:
            return
        self._drawn = (scene, names)
        with self._server.atomic():
            self._server.scene.remove_by_name("/highlight")
            found = roles(scene.region_names, session.specification.decomposition)
            for index, region in enumerate(scene.regions):
                if region.name in names:
                    height = HEIGHT[found[region.name]] + LIFT
                    self._outline(f"/highlight/region{index}", region, height)

    def _outline(self, name: str, region: Region, height: float) -> None:
        scene = self._server.scene
        if region.dimension == 2:
            segments = outline(region, height).astype(np.float32)
            scene.add_line_segments(name, segments, BRIGHT, thickness=THICKNESS)
            return
        size = tuple(GROWTH * length for length in region.size)
        shell = Region(region.name, region.kind, region.center, size, region.color)
        add_solid(scene, name, shell, BRIGHT, height, OPACITY)
