"""The ant: a ball on four legs of two moving parts, as in its MuJoCo model."""

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np
import viser
from viser.transforms import SO3

from envs import Ant
from envs.ant.model import ant_model
from studio.page.views.bodies.body import PAINT, ROOT, Camera, Color, Pose, Stage
from studio.page.views.bodies.pieces import Piece, add_pieces, capsule, hull

SAND, UMBER = (222, 170, 112), (120, 84, 52)
JOINTS = slice(7, 15)
"""Of the hips and ankles in the state, after the torso's position [3] and attitude [4]."""


class Spider:
    """Parts are the model's bodies."""

    stage = Stage(
        ((-3.3, 3.3), (-3.3, 3.3)),
        Camera((0.0, -9.6, 11.2), (0.0, -1.5, 0.0)),
        rim=(176, 124, 82),
    )

    def __init__(self, robot: Ant) -> None:
        del robot  # its model is the same in every simulator

    def build(self, scene: viser.SceneApi, node: str) -> Mapping[str, viser.SceneNodeHandle]:
        """A frame with solids for each body of the model."""
        parts = {}
        for name, solids in self.pieces().items():
            parts[name] = scene.add_frame(f"{node}/{name}", show_axes=False)
            add_pieces(scene, f"{node}/{name}", solids)
        return parts

    def pieces(self) -> Mapping[str, tuple[Piece, ...]]:
        """Solids of each part, in its frame."""
        return _pieces()

    def track(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """The states."""
        del actions
        return states

    def poses(self, row: np.ndarray) -> Mapping[str, Pose]:
        """The torso's pose from the state, the legs relative to it from the joint angles."""
        row = np.asarray(row, float)
        mujoco: Any = import_module("mujoco")
        model = ant_model()
        data = mujoco.MjData(model)
        data.qpos[:] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, *row[JOINTS]]
        mujoco.mj_kinematics(model, data)
        poses = {ROOT: Pose(row[:3], row[3:7] / np.linalg.norm(row[3:7]))}
        for body in range(1, model.nbody):
            poses[f"part{body}"] = Pose(data.xpos[body].copy(), data.xquat[body].copy())
        return poses


@cache
def _pieces() -> dict[str, tuple[Piece, ...]]:
    """Solids of each body, in its frame."""
    model = ant_model()
    found: dict[str, list[Piece]] = {f"part{body}": [] for body in range(1, model.nbody)}
    for geom in range(model.ngeom):
        body = model.geom_bodyid[geom]
        if body > 0:
            found[f"part{body}"].append(_piece(model, geom))
    return {name: tuple(pieces) for name, pieces in found.items()}


def _piece(model: Any, geom: int) -> Piece:
    """A capsule; a ball is one without length."""
    radius, half = model.geom_size[geom][:2]
    center = model.geom_pos[geom]
    along = SO3(model.geom_quat[geom]).apply(np.array([0.0, 0.0, half]))
    return hull(_color(model, geom), capsule(radius, center - along, center + along))


def _color(model: Any, geom: int) -> Color:
    """Bright torso, sand-coloured legs, dark feet."""
    name = model.geom(geom).name
    return PAINT if name == "torso_geom" else UMBER if "foot" in name else SAND
