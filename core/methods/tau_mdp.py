"""tau-MDP: the whole trajectory is part of the state, PPO learns from the robustness at the end.

App. A.3 (after Aksaray et al. 2016, who append a segment of the trajectory and learn by tabular
Q-learning): the state at step k is s_k = (x_0, ..., x_k), padded with zeros to the length of an
episode. Of past states the positions are kept, of which the formula's regions speak.

Dimensions: P slots of the trajectory, d position, n state.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp

from core.methods.whole_formula.features import scaled_position, state_features
from core.methods.whole_formula.feed_forward import Observed, feed_forward_method
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.task import Task


class Trail(NamedTuple):
    """The trajectory so far, and the step."""

    positions: Array  # [P, d] scaled; zeros for steps to come
    step: Array  # []


@dataclass(frozen=True)
class WholeTrajectory:
    """A `History` that forgets nothing; its data are the steps [P] of its slots."""

    def data(self, task: Task) -> Array:
        """A slot for each step at which there is an action to choose."""
        return jnp.arange(task.padded_horizon, dtype=jnp.int32)

    def start(self, problem: Problem, data: Array) -> Trail:
        """Nothing has happened."""
        shape = data.shape[0], problem.robot.position_size
        return Trail(jnp.zeros(shape), jnp.zeros((), jnp.int32))

    def observe(self, problem: Problem, data: Array, memory: Trail, state: Array) -> Observed:
        """The trail, lengthened by a state [n]."""
        now = (data == memory.step)[:, None]
        positions = jnp.where(now, scaled_position(problem, state), memory.positions)
        own = state_features(problem, state, memory.step)
        features = jnp.concatenate([own, positions.reshape(-1)])
        return Observed(Trail(positions, memory.step + 1), features, jnp.zeros(()))


TAU_MDP = feed_forward_method("tau-mdp", "τ-MDP (the trajectory in the state)", WholeTrajectory())
