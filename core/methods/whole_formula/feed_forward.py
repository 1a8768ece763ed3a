"""Policies whose memory is given, not learnt: actor and critic see the features of a history.

Dimensions: n state, f features.
"""

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple, Protocol

import jax
import jax.numpy as jnp

from core.compilation import shape_of
from core.methods.networks import make_networks
from core.methods.ppo import Transitions, improve
from core.methods.whole_formula.algorithm import PAPER_PPO, PolicyGradient
from core.methods.whole_formula.controller import SampledController
from core.methods.whole_formula.learner import PolicyLearner
from core.methods.whole_formula.method import WholeFormulaMethod
from core.methods.whole_formula.policy import Acted, PolicyWeights
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.task import Task


class Observed(NamedTuple):
    """What a history tells at one step."""

    memory: Any
    features: Array  # [f]
    paid: Array  # [] reward for having come here, in units of the robot's length


class History(Protocol):
    """A hashable value: what is kept of an episode. `start` and `observe` can be traced by JAX."""

    def data(self, task: Task) -> Any:
        """The formula's own numbers that it works with: a pytree of arrays, never learnt.

        Raises:
            UserError: the formula is outside of what the method knows.
        """
        ...

    def start(self, problem: Problem, data: Any) -> Any:
        """Before the first step of an episode."""
        ...

    def observe(self, problem: Problem, data: Any, memory: Any, state: Array) -> Observed:
        """With a further state [n]; the first is the initial one."""
        ...


@dataclass(frozen=True)
class FeedForwardPolicy:
    """A `Policy` that sees what a history keeps."""

    hidden: tuple[int, ...]
    history: History

    def initial(self, task: Task, algorithm: PolicyGradient, seed: int) -> PolicyWeights:
        """Orthogonal weights."""
        robot, data = task.robot, self.history.data(task)
        networks = make_networks(self.hidden, robot.action_size)
        count = self._feature_count(task.problem, data)
        return PolicyWeights(networks.initial(seed, count, count, algorithm.log_std), data)

    def shapes(self, task: Task) -> PolicyWeights:
        """Of the networks and the history's data."""
        data = self.history.data(task)
        count = self._feature_count(task.problem, data)
        networks = make_networks(self.hidden, task.robot.action_size)
        kept = jax.tree.map(lambda leaf: shape_of(*leaf.shape, dtype=leaf.dtype), data)
        return PolicyWeights(networks.shapes(count, count), kept)

    def start(self, problem: Problem, weights: PolicyWeights, state: Array) -> Any:
        """The history before the first step."""
        del state
        return self.history.start(problem, weights.memory)

    def act(self, problem: Problem, weights: PolicyWeights, memory: Any, state: Array) -> Acted:
        """The step in a state [n]."""
        observed = self.history.observe(problem, weights.memory, memory, state)
        networks = make_networks(self.hidden, problem.robot.action_size)
        mean = networks.action(weights.heads, observed.features)
        return Acted(observed.memory, observed.features, observed.paid, mean)

    def learnable(self, weights: PolicyWeights) -> Any:
        """Actor and critic."""
        return weights.heads

    def learn(
        self,
        algorithm: PolicyGradient,
        weights: PolicyWeights,
        optimizer: Any,
        transitions: Transitions,
        key: Array,
    ) -> tuple[PolicyWeights, Any]:
        """PPO."""
        networks = make_networks(self.hidden, transitions.noise.shape[-1])
        learnt = weights.heads, optimizer
        heads, optimizer = improve(algorithm, networks, learnt, transitions, key)
        return weights._replace(heads=heads), optimizer

    def _feature_count(self, problem: Problem, data: Any) -> int:
        state = shape_of(problem.robot.state_size, dtype=jnp.float32)
        memory = jax.eval_shape(self.history.start, problem, data)
        observed = jax.eval_shape(self.history.observe, problem, data, memory, state)
        return observed.features.shape[0]


def feed_forward_method(name: str, title: str, history: History) -> WholeFormulaMethod:
    """The method of policies that see what a history keeps."""
    return WholeFormulaMethod(
        name,
        title,
        PolicyGradient(),
        PAPER_PPO,
        partial(_learner, history),
        partial(_controller, history),
    )


def _learner(history: History, task: Task, algorithm: PolicyGradient) -> PolicyLearner:
    return PolicyLearner(task, algorithm, FeedForwardPolicy(algorithm.hidden, history))


def _controller(
    history: History, algorithm: PolicyGradient, weights: PolicyWeights
) -> SampledController:
    policy = FeedForwardPolicy(algorithm.hidden, history)
    return SampledController(policy, weights, jnp.int32(0))
