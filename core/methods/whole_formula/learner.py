"""PPO on whole episodes, with the formula's robustness as the reward at their end.

Dimensions: L steps, N environments.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import Program, shape_of
from core.memory import require_memory
from core.methods.method import Epoch
from core.methods.ppo import Transitions, make_optimizer
from core.methods.whole_formula.algorithm import PolicyGradient
from core.methods.whole_formula.controller import SampledController
from core.methods.whole_formula.episodes import Episodes, explore, reward_of, verdicts
from core.methods.whole_formula.policy import Policy, PolicyWeights
from core.task.protocols import Array
from core.task.task import Task


class LearnerState(NamedTuple):
    """Everything carried from one epoch to the next."""

    weights: PolicyWeights
    optimizer: Any
    key: Array


class EpochKeys(NamedTuple):
    """Random keys of an epoch by their purpose; each is used once."""

    episodes: Array
    learning: Array
    following: Array
    """The learner's key in the next epoch."""


def epoch_keys(key: Array) -> EpochKeys:
    """The keys of the epoch that begins with the learner's key."""
    return EpochKeys(*jax.random.split(key, 3))


def update(
    state: LearnerState,
    episodes: Episodes,
    final: Array,
    horizon: Array,
    *,
    policy: Policy,
    algorithm: PolicyGradient,
) -> LearnerState:
    """One epoch of PPO.

    Args:
        state: before it.
        episodes: of it.
        final: reward [N] at the end of each episode.
        horizon: step [] at which episodes end; what follows was only simulated.
        policy: what learns.
        algorithm: hyper-parameters.
    """
    keys = epoch_keys(state.key)
    step = jnp.arange(episodes.paid.shape[0])[:, None]
    last = jnp.broadcast_to(step == horizon - 1, episodes.paid.shape)
    transitions = Transitions(
        episodes.seen[:-1],
        episodes.seen,
        episodes.noise,
        episodes.paid + jnp.where(last, final, 0.0),
        last,
        jnp.broadcast_to(step < horizon, episodes.paid.shape).astype(jnp.float32),
    )
    weights, optimizer = policy.learn(
        algorithm, state.weights, state.optimizer, transitions, keys.learning
    )
    return LearnerState(weights, optimizer, keys.following)


_update = Program(update, fused=True)


@dataclass(frozen=True)
class PolicyLearner:
    """Learns on one task, in the robot's model where it has a true physics besides.

    Attributes:
        task: the grounded task.
        algorithm: hyper-parameters.
        policy: what learns.
    """

    task: Task
    algorithm: PolicyGradient
    policy: Policy

    @property
    def steps_per_epoch(self) -> int:
        """N times L."""
        return self.algorithm.environments * self.task.padded_horizon

    @property
    def evaluation_states(self) -> int:
        """Initial states of an evaluation while training."""
        return self.algorithm.evaluation_states

    @property
    def pace_change(self) -> None:
        """Epochs do not change."""
        return None

    @property
    def _exploration(self) -> dict[str, Any]:
        count, steps = self.algorithm.environments, self.task.padded_horizon
        return {"policy": self.policy, "count": count, "steps": steps}

    @property
    def _static(self) -> dict[str, Any]:
        return {"policy": self.policy, "algorithm": self.algorithm}

    def fresh(self, seed: int) -> LearnerState:
        """State before the first epoch: made on the host, nothing is compiled."""
        weights = self.policy.initial(self.task, self.algorithm, seed)
        optimizer = make_optimizer(self.algorithm).init(self.policy.learnable(weights))
        return LearnerState(weights, optimizer, jax.random.fold_in(jax.random.key(seed), 0))

    def jobs(self, state: LearnerState) -> list[Callable[[], Any]]:
        """Compilations that epochs need.

        Raises:
            UserError: an epoch takes more memory than is free.
        """
        problem, key = self.task.problem, epoch_keys(state.key).episodes
        episodes = explore.shapes(problem, state.weights, key, **self._exploration)
        require_memory(episodes, self.task.padded_horizon, self.algorithm.environments)
        final = shape_of(self.algorithm.environments, dtype=jnp.float32)
        horizon = problem.formula.horizon
        return [
            partial(explore.compile, problem, state.weights, key, **self._exploration),
            partial(_update.compile, state, episodes, final, horizon, **self._static),
        ]

    def epoch(self, state: LearnerState, number: int) -> tuple[LearnerState, Epoch]:
        """One episode in each environment, and PPO on them."""
        del number
        key, problem = epoch_keys(state.key).episodes, self.task.problem
        episodes = explore(problem, state.weights, key, **self._exploration)
        verdict = verdicts(self.task, episodes.margins, episodes.sound)
        final = jnp.asarray(reward_of(self.task, verdict))
        horizon = jnp.asarray(problem.formula.horizon)
        following = _update(state, episodes, final, horizon, **self._static)
        earned = np.asarray(episodes.paid)[: self.task.horizon].sum(0) + np.asarray(final)
        broken = int((~np.asarray(episodes.sound)).sum())
        return following, Epoch(
            float((verdict >= 0).mean()), float(earned.mean()) / self.task.horizon, broken
        )

    def weight_shapes(self) -> PolicyWeights:
        """Stands for the weights of any state."""
        return self.policy.shapes(self.task)

    def weights(self, state: LearnerState) -> PolicyWeights:
        """Of the policy."""
        return state.weights

    def with_weights(self, state: LearnerState, weights: PolicyWeights) -> LearnerState:
        """The state with other weights; it explores as at the start."""
        log_std = jnp.full_like(weights.heads.log_std, self.algorithm.log_std)
        heads = weights.heads._replace(log_std=log_std)
        return state._replace(weights=weights._replace(heads=heads))

    def controller(self, weights: PolicyWeights) -> SampledController:
        """The policy, which samples its actions from the second attempt on."""
        return SampledController(self.policy, weights, jnp.int32(0))
