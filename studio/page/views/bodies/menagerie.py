"""Franka's own meshes of its arm, from MuJoCo Menagerie if installed and downloaded.

`pip install tgpo-studio[meshes]` and `mujoco-menagerie prefetch franka_emika_panda` provide them;
nothing is downloaded from here. The model's links are framed as in `envs.panda`.
"""

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
import trimesh
from viser.transforms import SE3, SO3

from studio.page.views.bodies.pieces import Piece

ROBOT = "franka_emika_panda"
BODIES = {"base": ("link0",), "hand": ("hand", "left_finger", "right_finger")} | {
    f"link{joint}": (f"link{joint}",) for joint in range(1, 8)
}
"""The model's bodies that move together, by our names."""

OPENING = 0.02
"""Of each finger in [m]."""


@cache
def menagerie_pieces() -> dict[str, tuple[Piece, ...]] | None:
    """Pieces by link as in `arm_pieces`; None if there are none or they cannot be read."""
    try:
        model = _model()
        return None if model is None else _pieces(model)
    except Exception:  # noqa: BLE001 - optional decoration: our own shells will do
        return None


def _model() -> Any:
    """The compiled model, if it is already downloaded."""
    if find_spec("mujoco_menagerie") is None:
        return None
    menagerie = import_module("mujoco_menagerie")
    robot, cache = menagerie.get(ROBOT), menagerie.Cache()
    there = (cache.root / ROBOT).is_dir() if cache.root else cache.is_cached(robot)
    return robot.model(robot.default_model, cache) if there else None


def _pieces(model: Any) -> dict[str, tuple[Piece, ...]]:
    """Visible meshes of the bodies, each in the frame of our link."""
    mujoco: Any = import_module("mujoco")  # comes with the optional package
    data = mujoco.MjData(model)
    data.qpos[-2:] = OPENING
    mujoco.mj_kinematics(model, data)
    found = {}
    for name, bodies in BODIES.items():
        frame = _pose(
            data.xpos, data.xquat, model.body("link7" if name == "hand" else bodies[0]).id
        )
        found[name] = tuple(
            Piece(_mesh(model, geom).apply_transform((frame.inverse() @ place).as_matrix()), color)
            for geom, place, color in _visible(model, data, bodies)
        )
    return found


def _visible(model: Any, data: Any, bodies: tuple[str, ...]):
    """(geom, pose in the world, colour) of the meshes of some bodies that do not collide."""
    wanted = {model.body(body).id for body in bodies}
    for geom in range(model.ngeom):
        mesh = model.geom_dataid[geom] >= 0
        if model.geom_bodyid[geom] in wanted and mesh and not model.geom_contype[geom]:
            material = model.geom_matid[geom]
            rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom]
            red, green, blue = (int(255 * value) for value in rgba[:3])
            body = _pose(data.xpos, data.xquat, model.geom_bodyid[geom])
            yield geom, body @ _pose(model.geom_pos, model.geom_quat, geom), (red, green, blue)


def _mesh(model: Any, geom: int) -> trimesh.Trimesh:
    mesh = model.geom_dataid[geom]
    first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
    start, faces = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    return trimesh.Trimesh(
        np.array(model.mesh_vert[first : first + count]),
        np.array(model.mesh_face[start : start + faces]),
        process=False,
    )


def _pose(positions: np.ndarray, quaternions: np.ndarray, index: int) -> SE3:
    return SE3.from_rotation_and_translation(SO3(quaternions[index]), positions[index])
