"""The ant's true physics in MJX, with MuJoCo's own solver settings: for GPUs and TPUs.

Compiling takes most of a minute.
"""

import jax
import jax.numpy as jnp

from envs.ant.compiled import TorqueStep
from envs.ant.model import POSITIONS, SUBSTEPS, ant_model


def mjx_step() -> TorqueStep:
    """A control step of one ant."""
    from mujoco import mjx  # noqa: PLC0415 - slow to import

    model = mjx.put_model(ant_model())
    blank = mjx.make_data(model)

    def torque_step(state, torques):
        data = blank.replace(qpos=state[:POSITIONS], qvel=state[POSITIONS:], ctrl=torques)
        data, _ = jax.lax.scan(lambda d, _: (mjx.step(model, d), None), data, length=SUBSTEPS)
        return jnp.concatenate([data.qpos, data.qvel])

    return torque_step
