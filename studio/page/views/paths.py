"""The paths of regions that move: a thin line, and a dot at each waypoint."""

import numpy as np
import viser

from scenes import Region, Scene, unit_of
from studio.page.session import Session
from studio.page.views.regions import region_look
from studio.page.views.roles import roles
from studio.page.views.solids import rgb

LINE, DOT = 0.03, 0.06
"""Width of the line and radius of a dot, in units of the scene."""

LIFT = 0.02
"""Height of a path on the floor, in units of the scene."""


class PathsView:
    """Nodes `/paths/line0`, ... and `/paths/dots0`, ... in the order of the regions."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._drawn: tuple | None = None

    def draw(self, session: Session) -> None:
        """Follow the regions and their colours."""
        scene, decomposition = session.document.scene, session.specification.decomposition
        current = (scene, decomposition)
        if self._drawn is not None and all(a is b for a, b in zip(current, self._drawn)):  # noqa: B905
            return
        self._drawn = current
        found = roles(scene.region_names, decomposition)
        with self._server.atomic():
            self._server.scene.remove_by_name("/paths")
            for index, region in enumerate(scene.regions):
                if region.motion is not None:
                    color = rgb(region_look(region, found[region.name]).color)
                    self._show(scene, index, region, color)

    def _show(self, scene: Scene, index: int, region: Region, color: tuple[int, int, int]) -> None:
        unit = unit_of(scene)
        points = path_points(region, scene.horizon, LIFT * unit)
        dark = (color[0] // 2, color[1] // 2, color[2] // 2)
        self._server.scene.add_line_segments(
            f"/paths/line{index}",
            np.stack([points[:-1], points[1:]], axis=1).astype(np.float32),
            dark,
            thickness=LINE * unit,
        )
        for number, point in enumerate(points):
            self._server.scene.add_icosphere(
                f"/paths/dots{index}/{number}",
                DOT * unit,
                dark,
                subdivisions=2,
                position=point,
                cast_shadow=False,
            )


def path_points(region: Region, horizon: int, height: float) -> np.ndarray:
    """Waypoints [N, 3] of a region's path; of one without an end, where it is at the horizon.

    Args:
        region: one that moves.
        horizon: of the scene [steps].
        height: of paths in the plane [m].
    """
    motion = region.motion
    assert motion is not None
    steps = (0, horizon) if motion.endless else motion.steps
    points = region.center + motion.offset(steps)
    level = np.full((len(points), 3 - region.dimension), height)
    return np.column_stack([points, level])
