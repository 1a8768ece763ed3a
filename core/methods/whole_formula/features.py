"""What every policy of a whole formula sees at an instant: where the robot is, and the time.

TGPO's studio mode sees more (distance fields, the current leg). The paper's baselines know neither
subgoals nor obstacles: they have the state, what they remember, and the robustness at the end.
"""

import jax
import jax.numpy as jnp

from core.compilation import shape_of
from core.task.problem import Problem
from core.task.protocols import Array


def scaled_position(problem: Problem, state: Array) -> Array:
    """Position [d] in a state [n], about 1 at the edge of the workspace."""
    robot = problem.robot
    return robot.position(state) / (5 * robot.length)


def state_features(problem: Problem, state: Array, tau: Array) -> Array:
    """Position, the robot's own features and the share of the episode that is over [f]."""
    time = jnp.asarray(tau, jnp.float32) / problem.formula.horizon
    own = problem.robot.observe(state)
    return jnp.concatenate([scaled_position(problem, state), own, time[None]])


def state_feature_count(problem: Problem) -> int:
    """Number of those features."""
    state = shape_of(problem.robot.state_size, dtype=jnp.float32)
    tau = shape_of(dtype=jnp.float32)
    return jax.eval_shape(state_features, problem, state, tau).shape[0]
