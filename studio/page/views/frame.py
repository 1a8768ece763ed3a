"""Depth cues in 3D: the edges of the workspace, and lines from regions to the ground."""

from dataclasses import replace

import numpy as np
import viser

from scenes import Region, Scene, unit_of, workspace_of
from scenes.starts import inner_point
from studio.page.session import Session
from studio.page.views.outlines import outline
from studio.page.views.regions import shown_step
from studio.page.views.solids import seen
from studio.page.views.walls import Limits, hall, wall_of

EDGE, DROP = (206, 212, 218), (150, 158, 168)
ABOVE = 0.01
"""Height of footprints above the ground, in units of the scene."""


class FrameView:
    """Nodes `/frame/edges` and `/frame/drops`, for robots in 3D."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._drawn: tuple | None = None

    def draw(self, session: Session) -> None:
        """Follow the regions."""
        scene = session.document.scene
        step = shown_step(session) if scene.dimension == 3 else 0.0
        current = scene.robot, scene.arena, scene.regions, scene.initial, step
        if current == self._drawn:
            return
        self._drawn = current
        with self._server.atomic():
            self._server.scene.remove_by_name("/frame")
            if scene.dimension == 3:
                regions = tuple(region.displaced(step) for region in scene.regions)
                self._show(replace(scene, regions=regions))

    def _show(self, scene: Scene) -> None:
        limits = workspace_of(scene).arena
        inside = hall(scene.regions, limits)
        ground = inside[2][0] + ABOVE * unit_of(scene)
        drawn = (*scene.regions, seen(scene.initial, unit_of(scene)))
        floating = [region for region in drawn if wall_of(region, limits) is None]
        drops = [drop(region, ground) for region in floating]
        self._line("edges", _edges(inside), EDGE)
        self._line("drops", np.concatenate(drops), DROP)

    def _line(self, name: str, segments: np.ndarray, color: tuple[int, int, int]) -> None:
        if len(segments):
            self._server.scene.add_line_segments(
                f"/frame/{name}",
                segments.astype(np.float32),
                color,
                thickness=1.5,
                thickness_units="screen",
            )


def drop(region: Region, ground: float) -> np.ndarray:
    """Segments [n, 2, 3]: footprint at a height [m] and the line to it; none if it stands there."""
    if region.kind == "union":
        return np.concatenate([drop(part, ground) for part in region.parts])
    x, y, _ = inner_point(region)
    bottom = region.center[2] - region.half_extents[2]
    if bottom <= ground:
        return np.zeros((0, 2, 3))
    way = np.array([[[x, y, bottom], [x, y, ground]]])
    return np.concatenate([outline(_footprint(region), ground), way])


def _footprint(region: Region) -> Region:
    """What is below a region of space."""
    name, flat = region.name, region.center[:2]
    match region.kind:
        case "prism":
            return Region(name, "polygon", points=region.points)
        case "box":
            return Region(name, "rectangle", flat, region.size[:2], angle=region.angle)
    return Region(name, "circle", flat, region.size[:1])


def _edges(limits: Limits) -> np.ndarray:
    """Edges [12, 2, 3] of the hall."""
    center = tuple((low + high) / 2 for low, high in limits)
    half = tuple((high - low) / 2 for low, high in limits)
    return outline(Region("hall", "box", center, half), 0.0)
