"""The Panda's kinematics against MuJoCo's, for a chain built from Franka's published table."""

import math

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from envs import Panda
from tests.envs.reference import PANDA_HIGH, PANDA_LOW

CHAIN = (
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -math.pi / 2),
    (0.0, 0.316, math.pi / 2),
    (0.0825, 0.0, math.pi / 2),
    (-0.0825, 0.384, -math.pi / 2),
    (0.0, 0.0, math.pi / 2),
    (0.088, 0.0, math.pi / 2),
)
"""Craig's (a [m], d [m], alpha [rad]) of each joint, Franka Control Interface documentation."""


def _model() -> str:
    """Nested bodies: Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d), and the hand at the end."""
    opening, closing = "", ""
    for a, d, alpha in CHAIN:
        turn = f"{math.cos(alpha / 2)} {math.sin(alpha / 2)} 0 0"
        along = f"{a} {-d * math.sin(alpha)} {d * math.cos(alpha)}"
        opening += f'<body pos="{along}" quat="{turn}"><inertial pos="0 0 0" mass="1" '
        opening += 'diaginertia="1 1 1"/><joint type="hinge" axis="0 0 1"/>'
        closing += "</body>"
    tip = '<site name="tip" pos="0 0 0.2104"/>'
    return f"<mujoco><worldbody>{opening}{tip}{closing}</worldbody></mujoco>"


def test_forward_kinematics_and_jacobian_equal_mujocos():
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(_model())
    data = mujoco.MjData(model)
    site = model.site("tip").id
    postures = np.random.default_rng(11).uniform(PANDA_LOW, PANDA_HIGH, (200, 7))
    with jax.enable_x64(True):
        tips = np.asarray(Panda().position(jnp.asarray(postures)))
        slopes = np.asarray(jax.vmap(Panda().jacobian)(jnp.asarray(postures)))
    for posture, tip, slope in zip(postures, tips, slopes, strict=True):
        data.qpos[:] = posture
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        jacobian = np.zeros((3, 7))
        mujoco.mj_jacSite(model, data, jacobian, None, site)
        np.testing.assert_allclose(tip, data.site_xpos[site], atol=1e-6)
        np.testing.assert_allclose(slope, jacobian, atol=1e-6)
