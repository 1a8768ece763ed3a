"""RNN: a recurrent network encodes the history, PPO learns from the robustness at the end.

App. A.3, "RNN" (after Liu et al. 2021): a gated recurrent unit reads what is seen at each step, and
actor and critic see its state h beside it:

    h_k = GRU(h_{k-1}, x_k),    u_k ~ N(actor(h_k, x_k), sigma),    V_k = critic(h_k, x_k)

Gradients go back through the whole episode; minibatches are sets of environments. Fast to write
down, slow to run: the recurrence leaves no two steps to be computed at once (App. A.5).

Dimensions: L steps, N environments, f what is seen, h units.
"""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np
import optax

from core.compilation import shape_of
from core.methods.bounds import Width
from core.methods.networks import make_networks, orthogonal
from core.methods.ppo import Samples, Transitions, make_optimizer, samples_of, surrogate
from core.methods.whole_formula.algorithm import PolicyGradient
from core.methods.whole_formula.controller import SampledController
from core.methods.whole_formula.features import state_feature_count, state_features
from core.methods.whole_formula.learner import PolicyLearner
from core.methods.whole_formula.method import WholeFormulaMethod
from core.methods.whole_formula.policy import Acted, PolicyWeights
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.task import Task


@dataclass(frozen=True)
class Recurrent(PolicyGradient):
    """Its hyper-parameters."""

    units: Width = 64
    """Of the recurrent network."""


class RecurrentMemory(NamedTuple):
    """What the recurrent network keeps, and the step."""

    hidden: Array  # [h]
    tau: Array  # []


@dataclass(frozen=True)
class RecurrentPolicy:
    """See the module; a `Policy`, whose memory works with the parameters of the recurrent unit."""

    hidden: tuple[int, ...]
    units: int

    def initial(self, task: Task, algorithm: Recurrent, seed: int) -> PolicyWeights:
        """Orthogonal weights; those of the recurrent unit too."""
        count, problem = state_feature_count(task.problem), task.problem
        networks = make_networks(self.hidden, problem.robot.action_size)
        heads = networks.initial(seed, self.units + count, self.units + count, algorithm.log_std)
        return PolicyWeights(heads, _initial_cell(self._cell, count, seed))

    def shapes(self, task: Task) -> PolicyWeights:
        """Of the networks and the recurrent unit."""
        count = state_feature_count(task.problem)
        networks = make_networks(self.hidden, task.robot.action_size)
        heads = networks.shapes(self.units + count, self.units + count)
        return PolicyWeights(heads, _cell_shapes(self._cell, count))

    def start(self, problem: Problem, weights: PolicyWeights, state: Array) -> RecurrentMemory:
        """Nothing is remembered."""
        del problem, weights, state
        return RecurrentMemory(jnp.zeros(self.units), jnp.zeros(()))

    def act(
        self, problem: Problem, weights: PolicyWeights, memory: RecurrentMemory, state: Array
    ) -> Acted:
        """The step in a state [n]."""
        seen = state_features(problem, state, memory.tau)
        hidden = self._after(weights.memory, memory.hidden, seen)
        networks = make_networks(self.hidden, problem.robot.action_size)
        mean = networks.action(weights.heads, jnp.concatenate([hidden, seen]))
        return Acted(RecurrentMemory(hidden, memory.tau + 1), seen, jnp.zeros(()), mean)

    def learnable(self, weights: PolicyWeights) -> PolicyWeights:
        """All."""
        return weights

    def learn(
        self,
        algorithm: Recurrent,
        weights: PolicyWeights,
        optimizer: Any,
        transitions: Transitions,
        key: Array,
    ) -> tuple[PolicyWeights, Any]:
        """PPO whose gradients go back through the episodes."""
        networks = make_networks(self.hidden, transitions.noise.shape[-1])
        encoded = self._encoded(weights.memory, transitions.critic)
        samples = samples_of(algorithm, networks.value(weights.heads, encoded), transitions)
        old_mean = networks.action(weights.heads, encoded[:-1])
        old_log_std = weights.heads.log_std
        count = transitions.reward.shape[1]
        per_minibatch = count // algorithm.minibatches

        def loss(weights: PolicyWeights, before: Array, chosen: Samples) -> Array:
            read = self._encoded(weights.memory, chosen.policy)
            chosen = chosen._replace(policy=read, critic=read)
            return surrogate(weights.heads, (before, old_log_std), chosen, networks, algorithm.clip)

        def minibatch(carry, index):
            weights, state = carry
            chosen = jax.tree.map(lambda leaf: leaf[:, index], samples)
            gradient = jax.grad(loss)(weights, old_mean[:, index], chosen)
            updates, state = make_optimizer(algorithm).update(gradient, state, weights)
            return (optax.apply_updates(weights, updates), state), None

        def one_pass(carry, pass_key):
            order = jax.random.permutation(pass_key, count)
            order = order[: per_minibatch * algorithm.minibatches]
            return jax.lax.scan(minibatch, carry, order.reshape(algorithm.minibatches, -1))

        passes = jax.random.split(key, algorithm.passes)
        learnt: Any = jax.lax.scan(one_pass, (weights, optimizer), passes)[0]
        return learnt

    @property
    def _cell(self) -> nn.GRUCell:
        return nn.GRUCell(self.units)

    def _after(self, cell: Any, hidden: Array, seen: Array) -> Array:
        """The unit's state [..., h] after what is seen [..., f]."""
        result: Any = self._cell.apply(cell, hidden, seen)
        return result[0]

    def _encoded(self, cell: Any, seen: Array) -> Array:
        """What actor and critic see [L, N, h + f] of episodes [L, N, f] from their start."""

        def step(hidden: Array, now: Array) -> tuple[Array, Array]:
            hidden = self._after(cell, hidden, now)
            return hidden, hidden

        start = jnp.zeros((seen.shape[1], self.units))
        _, hidden = jax.lax.scan(step, start, seen)
        return jnp.concatenate([hidden, seen], -1)


def _initial_cell(cell: nn.GRUCell, inputs: int, seed: int) -> Any:
    """Parameters of a recurrent unit with orthogonal kernels and zero biases, made on the host."""
    random = np.random.default_rng([seed, 1])

    def made(leaf: Any) -> Array:
        if len(leaf.shape) < 2:  # a bias
            return jnp.zeros(leaf.shape, jnp.float32)
        rows, columns = leaf.shape
        return jnp.asarray(orthogonal(rows, columns, random), jnp.float32)

    return jax.tree.map(made, _cell_shapes(cell, inputs))


def _cell_shapes(cell: nn.GRUCell, inputs: int) -> Any:
    """Stands for the parameters of a recurrent unit."""
    hidden = shape_of(cell.features, dtype=jnp.float32)
    seen = shape_of(inputs, dtype=jnp.float32)
    return jax.eval_shape(cell.init, jax.random.key(0), hidden, seen)


def _policy(algorithm: Recurrent) -> RecurrentPolicy:
    return RecurrentPolicy(algorithm.hidden, algorithm.units)


def _learner(task: Task, algorithm: Recurrent) -> PolicyLearner:
    return PolicyLearner(task, algorithm, _policy(algorithm))


def _controller(algorithm: Recurrent, weights: PolicyWeights) -> SampledController:
    return SampledController(_policy(algorithm), weights, jnp.int32(0))


_STUDIO = Recurrent(minibatches=4)

RNN = WholeFormulaMethod(
    "rnn",
    "RNN (recurrent PPO, robustness at the end)",
    _STUDIO,
    replace(
        _STUDIO,
        mode="paper",
        hidden=(512, 512, 512),
        units=512,
        learning_rate=3e-4,
        weight_decay=0.1,
    ),
    _learner,
    _controller,
)
