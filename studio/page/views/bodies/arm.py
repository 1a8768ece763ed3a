"""Franka's arm on a table, posed by its kinematics."""

from collections.abc import Mapping
from functools import cache

import jax
import numpy as np
import viser
from viser.transforms import SO3

from envs import Panda
from studio.page.views.bodies.arm_pieces import arm_pieces
from studio.page.views.bodies.body import PAINT, ROOT, Camera, Pose, Stage, upright
from studio.page.views.bodies.menagerie import menagerie_pieces
from studio.page.views.bodies.pieces import add_pieces

WOOD, GRAIN, LEG = (233, 220, 200), (221, 205, 181), (196, 180, 156)
TABLE = ((-0.28, 1.0), (-0.82, 0.82))
HEIGHT, THICK = 0.62, 0.045
"""Of the table and its top in [m]."""

TIP = "tip"
"""The point between the fingers, to which formulas refer."""


class Arm:
    """The table's top is z = 0, the robot's base the origin."""

    stage = Stage(
        TABLE,
        Camera((2.75, -2.4, 2.0), (0.42, -0.12, 0.02), 0.75),
        cell=0.1,
        color=WOOD,
        grid=GRAIN,
        thickness=THICK,
        fixed=True,
    )

    def __init__(self, robot: Panda) -> None:
        self._robot = robot

    def build(self, scene: viser.SceneApi, node: str) -> Mapping[str, viser.SceneNodeHandle]:
        """The table's legs, the links, and a mark at the end effector's position."""
        (left, right), (front, back) = TABLE
        for index, (x, y) in enumerate(
            ((left, front), (left, back), (right, front), (right, back))
        ):
            inward = (x + np.sign(0.3 - x) * 0.06, y - np.sign(y) * 0.06, -HEIGHT / 2 - THICK)
            scene.add_box(f"{node}/leg{index}", LEG, (0.07, 0.07, HEIGHT), position=inward)
        parts = {}
        for name, pieces in (menagerie_pieces() or arm_pieces()).items():
            parts[name] = scene.add_frame(f"{node}/{name}", show_axes=False)
            add_pieces(scene, f"{node}/{name}", pieces)
        parts[TIP] = scene.add_icosphere(f"{node}/{TIP}", 0.012, PAINT)
        return parts

    def track(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """The joint angles."""
        del actions
        return states

    def poses(self, row: np.ndarray) -> Mapping[str, Pose]:
        """Frames of the links; the hand moves with the seventh."""
        turns, origins, tip = (np.asarray(part, float) for part in _frames(self._robot)(row))
        poses = {ROOT: upright(np.zeros(3)), "base": upright(np.zeros(3))}
        for joint, (turn, origin) in enumerate(zip(turns, origins, strict=True), start=1):
            poses[f"link{joint}"] = Pose(origin, SO3.from_matrix(turn).wxyz)
        poses["hand"] = poses["link7"]
        poses[TIP] = Pose(tip, poses["link7"].wxyz)
        return poses


@cache
def _frames(robot: Panda):
    return jax.jit(robot.frames)
