"""Brax's ant in MuJoCo: the model, its state and its standing posture.

State [29]: qpos [15] = torso position (x, y, z) [m], quaternion (w, x, y, z), joint angles [8]
[rad]; qvel [14] = torso velocity in the world [m/s], angular velocity in the torso's frame
[rad/s], joint rates [8] [rad/s]. Joints and motors come as (hip, ankle) of legs 1 to 4, which
point to the torso's +x+y, -x+y, -x-y and +x-y.

A control step is 0.05 s: five steps of MuJoCo's 0.01 s with the torques held.
"""

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

POSITIONS, VELOCITIES, MOTORS = 15, 14, 8
STATE = POSITIONS + VELOCITIES
SUBSTEPS = 5
DT = 0.05
"""Duration of a control step [s]."""

STANDING = np.array([0, 0, 0.55, 1, 0, 0, 0, 0, 1, 0, -1, 0, -1, 0, 1] + [0] * VELOCITIES, float)
"""State [29] at rest above the origin, heading along x, feet on the ground."""

LOW, HIGH = 0.2, 1.0
"""Heights of the torso between which the ant walks [m]."""

UPRIGHT = 0.2
"""Least vertical component of the torso's own z axis in an ant that has not fallen."""

WILD = 200.0
"""Speed [m/s or rad/s] from which a simulation counts as broken down."""


@cache
def ant_model() -> Any:
    """The `mujoco.MjModel` of brax's ant.xml."""
    import mujoco  # noqa: PLC0415 - heavy, and only Ant needs it

    brax = find_spec("brax")  # importing it takes seconds
    assert brax is not None and brax.origin is not None
    path = Path(brax.origin).parent / "envs" / "assets" / "ant.xml"
    text = path.read_text(encoding="utf-8")
    model = mujoco.MjModel.from_xml_string(text)  # pyright: ignore[reportAttributeAccessIssue]
    assert (model.nq, model.nv, model.nu) == (POSITIONS, VELOCITIES, MOTORS)
    assert np.isclose(model.opt.timestep * SUBSTEPS, DT)
    return model


def rotation(quaternion: Any, xp: Any = np) -> Any:
    """Rotation matrices [..., 3, 3] from the torso's frame to the world of quaternions [..., 4]."""
    length = xp.sqrt((quaternion**2).sum(-1, keepdims=True)) + 1e-9
    w, x, y, z = xp.moveaxis(quaternion / length, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return xp.stack([xp.stack(row, -1) for row in rows], -2)


def has_fallen(states: np.ndarray) -> np.ndarray:
    """Whether each of the states [N, 29] is no longer walking: too low, too high, tilted, wild."""
    height, upright = states[:, 2], rotation(states[:, 3:7])[:, 2, 2]
    walking = (height > LOW) & (height < HIGH) & (upright > UPRIGHT) & is_sound(states)
    return ~walking  # also where a number is not finite


def is_sound(states: np.ndarray) -> np.ndarray:
    """Whether each of the states [N, 29] is finite and moves at a sane speed."""
    finite = np.isfinite(states).all(axis=1)
    return np.asarray(finite & (np.abs(states[:, POSITIONS:]) < WILD).all(axis=1))
