"""A quadrotor with turning rotors, drawn at twice its size to be visible in the hall."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import jax
import jax.numpy as jnp
import numpy as np
import viser
from viser.transforms import SO3

from envs import Quadrotor
from studio.page.views.bodies.body import (
    DARK,
    LIGHT,
    PAINT,
    ROOT,
    Camera,
    Pose,
    plain_stage,
    rotation,
)
from studio.page.views.bodies.pieces import Piece, add_pieces, block, drum, hull

SCALE = 2.0
BLADE, STEEL = (40, 44, 52), (134, 142, 150)

SPIN = 14.0
"""Displayed rotor speed when hovering, slow enough to be seen [rad/s]."""

SENSE = (1.0, -1.0, 1.0, -1.0)
"""Turning direction of the front, right, back and left rotor."""

ATTITUDE = slice(6, 9)
"""Roll, pitch and yaw in the state."""


class Multirotor:
    """x points forward, y left, z up in the body's frame."""

    def __init__(self, robot: Quadrotor) -> None:
        self._robot = robot
        camera = Camera((7.6, -22.0, 18.0), (0.0, -2.0, 0.0), 0.72)
        self.stage = replace(plain_stage(robot.workspace.arena), camera=camera)

    def build(self, scene: viser.SceneApi, node: str) -> Mapping[str, viser.SceneNodeHandle]:
        """Hull, arms, motors, and a rotor on each."""
        add_pieces(scene, f"{node}/frame", _frame(SCALE * self._robot.arm))
        rotors = {}
        for index, place in enumerate(self._motors()):
            name = f"rotor{index}"
            rotors[name] = scene.add_frame(f"{node}/{name}", show_axes=False, position=place)
            add_pieces(scene, f"{node}/{name}", _blades())
            scene.add_cylinder(
                f"{node}/{name}/disc", 0.19, 0.004, STEEL, opacity=0.28, cast_shadow=False
            )
        return rotors

    def track(self, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
        """The states and the rotors' angles [T + 1, 12 + 4]: speed ~ sqrt(force)."""
        forces = np.asarray(_forces(self._robot)(states[: len(actions)], actions))
        speed = SPIN * np.sqrt(np.maximum(forces, 0.0) / self._robot.hover_force) * SENSE
        angles = np.cumsum(np.nan_to_num(speed) * self._robot.dt, axis=0)
        return np.concatenate([states, np.concatenate([np.zeros((1, 4)), angles])], axis=1)

    def poses(self, row: np.ndarray) -> Mapping[str, Pose]:
        """The paper's z points down: half a turn about x there, and back."""
        roll, pitch, yaw = row[ATTITUDE]
        attitude = SO3.from_z_radians(-yaw) @ SO3.from_y_radians(-pitch) @ SO3.from_x_radians(roll)
        size = self._robot.state_size
        position = np.asarray(self._robot.position(jnp.asarray(row[:size])))
        poses = {ROOT: Pose(position, attitude.wxyz)}
        angles = row[size:] if len(row) > size else np.zeros(4)
        for index, (place, angle) in enumerate(zip(self._motors(), angles, strict=True)):
            poses[f"rotor{index}"] = Pose(np.array(place), rotation(angle, 2))
        return poses

    def _motors(self) -> tuple[tuple[float, float, float], ...]:
        """Positions of the front, right, back and left rotor [m]."""
        arm = SCALE * self._robot.arm
        return (arm, 0.0, 0.075), (0.0, -arm, 0.075), (-arm, 0.0, 0.075), (0.0, arm, 0.075)


@cache
def _forces(robot: Quadrotor):
    return jax.jit(jax.vmap(robot.motor_forces))


@cache
def _frame(arm: float) -> tuple[Piece, ...]:
    """Hull with a bright top, arms (the front one bright), motors and lamps."""
    sides = ((1, 0), (0, -1), (-1, 0), (0, 1))
    pieces = [
        hull(DARK, drum(0.13, (0, 0, -0.05), (0, 0, 0.03), 0.03)),
        hull(PAINT, drum(0.1, (0, 0, 0.02), (0, 0, 0.065), 0.03)),
        hull(LIGHT, block((0.02, 0.05, 0.015), (0.125, 0, 0), 0.006)),
    ]
    for index, (x, y) in enumerate(sides):
        tip = (arm * x, arm * y, 0.0)
        pieces += [
            hull(PAINT if index == 0 else DARK, drum(0.02, (0, 0, 0), tip)),
            hull(DARK, drum(0.035, (*tip[:2], -0.03), (*tip[:2], 0.06))),
        ]
    return tuple(pieces)


@cache
def _blades() -> tuple[Piece, ...]:
    """Two blades on a hub."""
    return (
        hull(BLADE, block((0.18, 0.016, 0.004), edge=0.003)),
        hull(STEEL, drum(0.02, (0, 0, -0.01), (0, 0, 0.015))),
    )
