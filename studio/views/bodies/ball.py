"""A ball on a dark foot, for a robot without a heading."""

from collections.abc import Mapping

import numpy as np
import viser

from studio.views.bodies.body import ARENA, DARK, OVERHEAD, PAINT, ROOT, Pose, Stage, upright


class Ball:
    """Stands where the robot is."""

    stage = Stage(ARENA, OVERHEAD)

    def build(self, scene: viser.SceneApi, node: str) -> Mapping[str, viser.SceneNodeHandle]:
        """Foot and ball."""
        scene.add_cylinder(f"{node}/foot", 0.2, 0.04, DARK, position=(0, 0, 0.03))
        scene.add_icosphere(f"{node}/ball", 0.16, PAINT, subdivisions=4, position=(0, 0, 0.2))
        return {}

    def track(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """The states."""
        del actions
        return states

    def poses(self, row: np.ndarray) -> Mapping[str, Pose]:
        """Upright at (x, y)."""
        return {ROOT: upright(row[:2])}
