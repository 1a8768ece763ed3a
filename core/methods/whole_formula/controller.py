"""The controller of a policy with a memory: its mean action, or in later attempts a sampled one.

The paper gives its baselines ten attempts (Sec. 5.1), which differ because their actions are drawn
from the learnt Gaussian. Here the first attempt takes the mean action, and the nine that follow
draw theirs. Controllers have no randomness of their own, so the draws depend on the attempt's
number, the initial state and the step alone, and any rollout can be repeated.
"""

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from core.methods.whole_formula.policy import Policy, PolicyWeights
from core.task.problem import Problem
from core.task.protocols import Array

ATTEMPTS = 10
"""From each initial state (Sec. 5.1)."""


class Memory(NamedTuple):
    """The policy's own memory, and where the draws of an episode stand."""

    own: Any
    seed: Array  # [2] key data of the episode
    step: Array  # []


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class SampledController:
    """Carries out the formula as a whole (see `core.controller`)."""

    policy: Policy = field(metadata={"static": True})
    weights: PolicyWeights
    number: Array  # [] of the attempt; 0 takes the mean action

    @property
    def search(self) -> None:
        """It chooses no times."""
        return None

    @property
    def attempts(self) -> tuple["SampledController", ...]:
        """Ten."""
        return tuple(replace(self, number=jnp.int32(number)) for number in range(ATTEMPTS))

    def score(self, problem: Problem, state: Array, schedule: Array) -> Array:
        """Nothing is promised of a schedule."""
        del problem, state, schedule
        return jnp.zeros(())

    def start(self, problem: Problem, state: Array, schedule: Array) -> Memory:
        """Memory before the first step."""
        del schedule
        bits = jax.lax.bitcast_convert_type(state.astype(jnp.float32), jnp.uint32)
        mixed = (bits * jnp.arange(1, 2 * bits.shape[0], 2, dtype=jnp.uint32)).sum(dtype=jnp.uint32)
        key = jax.random.fold_in(jax.random.fold_in(jax.random.key(0), self.number), mixed)
        own = self.policy.start(problem, self.weights, state)
        return Memory(own, jax.random.key_data(key), jnp.zeros((), jnp.int32))

    def step(self, problem: Problem, memory: Memory, state: Array) -> tuple[Memory, Array]:
        """The action [m] for a measured state [n], clipped to [-1, 1]."""
        acted = self.policy.act(problem, self.weights, memory.own, state)
        key = jax.random.fold_in(jax.random.wrap_key_data(memory.seed), memory.step)
        drawn = jnp.exp(self.weights.heads.log_std) * jax.random.normal(key, acted.mean.shape)
        action = acted.mean + jnp.where(self.number > 0, drawn, 0.0)
        following = Memory(acted.memory, memory.seed, memory.step + 1)
        return following, jnp.clip(action, -1.0, 1.0)
