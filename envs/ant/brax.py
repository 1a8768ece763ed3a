"""The ant of `brax.envs`, the paper's simulator, in its own settings.

Brax solves contacts by one Newton iteration of four line-search steps and damps joints
explicitly: a seventh of MJX's time on a CPU, and softer ground. Of brax's engines this is `mjx`:
on the `generalized` one the gait, which was learnt in MuJoCo, leaps instead of walking (in five
seconds eight ants of ten rise above 1 m and half of them end on their backs).
"""

import warnings

import jax.numpy as jnp
import numpy as np

from envs.ant.compiled import TorqueStep
from envs.ant.model import DT, MOTORS, POSITIONS, VELOCITIES


def brax_step() -> TorqueStep:
    """A control step of one ant."""
    from brax.envs.ant import Ant  # noqa: PLC0415 - takes seconds

    warnings.filterwarnings("ignore", "Brax System", module="brax")  # no longer developed
    ant = Ant(backend="mjx")
    assert (ant.sys.q_size(), ant.sys.qd_size(), ant.action_size) == (POSITIONS, VELOCITIES, MOTORS)
    assert np.isclose(ant.dt, DT)

    def torque_step(state, torques):
        physics = ant.pipeline_init(state[:POSITIONS], state[POSITIONS:])
        physics = ant.pipeline_step(physics, torques)
        return jnp.concatenate([physics.q, physics.qd])

    return torque_step
