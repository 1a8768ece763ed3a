"""Proximal policy optimisation (Schulman et al. 2017) on batches of transitions.

Dimensions: L steps, N environments, B = L * N transitions, f and g features of policy and critic,
m action.
"""

from typing import Any, NamedTuple, Protocol, cast

import jax
import jax.numpy as jnp
import optax

from core.methods.networks import Networks, Parameters
from core.task.protocols import Array


class Ppo(Protocol):
    """Hyper-parameters of PPO."""

    @property
    def learning_rate(self) -> float:
        """Of Adam."""
        ...

    @property
    def decay_epochs(self) -> int:
        """Epochs over which the learning rate falls to a fiftieth along a cosine; 0 keeps it."""
        ...

    @property
    def weight_decay(self) -> float:
        """Decoupled from the gradient."""
        ...

    @property
    def gradient_norm(self) -> float:
        """Norm to which gradients are clipped."""
        ...

    @property
    def passes(self) -> int:
        """Passes over a batch."""
        ...

    @property
    def minibatches(self) -> int:
        """Of a pass."""
        ...

    @property
    def discount(self) -> float:
        """Gamma."""
        ...

    @property
    def trace(self) -> float:
        """Lambda of the generalised advantage estimate."""
        ...

    @property
    def clip(self) -> float:
        """Of the ratio of probabilities."""
        ...


class Transitions(NamedTuple):
    """What a batch teaches."""

    policy: Array  # [L, N, f]
    critic: Array  # [L + 1, N, g]
    noise: Array  # [L, N, m] standardised deviation of the action from its mean
    reward: Array  # [L, N]
    ended: Array  # [L, N] the transition ended its episode (termination)
    weight: Array  # [L, N] 0 for transitions that do not count


class Samples(NamedTuple):
    """Flattened transitions of a batch."""

    policy: Array  # [B, f]
    critic: Array  # [B, g]
    noise: Array  # [B, m]
    advantage: Array  # [B] standardised
    target: Array  # [B] of the critic
    weight: Array  # [B]


def make_optimizer(settings: Ppo) -> optax.GradientTransformation:
    """Adam with decoupled weight decay, after clipping the gradient's norm."""
    return optax.chain(
        optax.clip_by_global_norm(settings.gradient_norm),
        optax.adamw(_learning_rate(settings), weight_decay=settings.weight_decay),
    )


def _learning_rate(settings: Ppo) -> optax.ScalarOrSchedule:
    if not settings.decay_epochs:
        return settings.learning_rate
    steps = settings.decay_epochs * settings.passes * settings.minibatches
    return optax.cosine_decay_schedule(settings.learning_rate, steps, alpha=0.02)


def advantages(reward: Array, value: Array, ended: Array, discount: float, trace: float) -> Array:
    """Generalised advantage estimates [L, N] (Schulman et al. 2016).

    Args:
        reward: [L, N].
        value: critic's values [L + 1, N] of the states before each step and after the last.
        ended: [L, N] 1 where the episode terminated, so that nothing follows; a batch that
            breaks off an episode (truncation) is continued by the critic's value instead.
        discount: gamma.
        trace: lambda.
    """
    goes_on = 1.0 - ended
    delta = reward + discount * value[1:] * goes_on - value[:-1]

    def backward(following, inputs):
        error, factor = inputs
        current = error + discount * trace * factor * following
        return current, current

    _, result = jax.lax.scan(backward, jnp.zeros(reward.shape[1:]), (delta, goes_on), reverse=True)
    return result


def samples_of(settings: Ppo, value: Array, transitions: Transitions) -> Samples:
    """Advantages and targets of transitions, not flattened: [L, N, ...].

    `value` holds the critic's values [L + 1, N].
    """
    ended = transitions.ended.astype(jnp.float32)
    advantage = advantages(transitions.reward, value, ended, settings.discount, settings.trace)
    target = advantage + value[:-1]
    weight = transitions.weight / jnp.maximum(transitions.weight.mean(), 1e-6)
    mean = (weight * advantage).mean()
    deviation = jnp.sqrt((weight * (advantage - mean) ** 2).mean())
    return Samples(
        transitions.policy,
        transitions.critic[:-1],
        transitions.noise,
        (advantage - mean) / (deviation + 1e-8),
        target,
        weight,
    )


def flatten(
    settings: Ppo, networks: Networks, parameters: Parameters, transitions: Transitions
) -> Samples:
    """Advantages and targets of transitions, flattened."""
    value = networks.value(parameters, transitions.critic)
    samples = samples_of(settings, value, transitions)
    return Samples(*(a.reshape((-1,) + a.shape[2:]) for a in samples))


def surrogate(
    parameters: Parameters,
    before: tuple[Array, Array],
    samples: Samples,
    networks: Networks,
    clip: float,
) -> Array:
    """PPO's clipped objective plus half the critic's squared error.

    `before` holds the mean actions [B, m] and the log standard deviation [m] that acted.
    """
    old_mean, old_log_std = before
    action = old_mean + jnp.exp(old_log_std) * samples.noise
    deviation = (action - networks.action(parameters, samples.policy)) / jnp.exp(parameters.log_std)
    log_ratio = (0.5 * (samples.noise**2 - deviation**2) + old_log_std - parameters.log_std).sum(-1)
    ratio = jnp.exp(log_ratio)
    clipped = jnp.clip(ratio, 1 - clip, 1 + clip)
    gain = jnp.minimum(ratio * samples.advantage, clipped * samples.advantage)
    error = networks.value(parameters, samples.critic) - samples.target
    return (samples.weight * (0.5 * error**2 - gain)).mean()


def improve(
    settings: Ppo,
    networks: Networks,
    learnt: tuple[Parameters, Any],
    transitions: Transitions,
    key: Array,
) -> tuple[Parameters, Any]:
    """One epoch on a batch: the parameters and the optimiser's state, before and after."""
    parameters, optimizer_state = learnt
    optimizer = make_optimizer(settings)
    samples = flatten(settings, networks, parameters, transitions)
    old_mean = networks.action(parameters, samples.policy)
    old_log_std = parameters.log_std
    size = samples.weight.shape[0]
    per_minibatch = size // settings.minibatches

    def minibatch(carry, index):
        parameters, optimizer_state = carry
        chosen = jax.tree.map(lambda leaf: leaf[index], samples)
        gradient = jax.grad(surrogate)(
            parameters, (old_mean[index], old_log_std), chosen, networks, settings.clip
        )
        updates, optimizer_state = optimizer.update(gradient, optimizer_state, parameters)
        return (optax.apply_updates(parameters, updates), optimizer_state), None

    def one_pass(carry, pass_key):
        order = jax.random.permutation(pass_key, size)[: per_minibatch * settings.minibatches]
        return jax.lax.scan(minibatch, carry, order.reshape(settings.minibatches, -1))

    carry = (parameters, optimizer_state)
    (parameters, optimizer_state), _ = jax.lax.scan(
        one_pass, carry, jax.random.split(key, settings.passes)
    )
    return cast(Parameters, parameters), optimizer_state
