"""Proximal policy optimisation on the batches of the grounded MDP (Schulman et al. 2017).

Dimensions: L steps, N environments, B = L * N transitions.
"""

from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import optax

from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.collection import Batch
from core.methods.tgpo.networks import Networks, Parameters, make_networks
from core.methods.tgpo.sampler import Elite, update_elite
from core.task.protocols import Array


class LearnerState(NamedTuple):
    """Everything carried from one epoch to the next."""

    parameters: Parameters
    optimizer: Any
    key: Array
    chains: Array  # [C, V]
    elite: Elite


class EpochKeys(NamedTuple):
    """Random keys of an epoch by their purpose; each is used once."""

    collection: Array
    shuffling: Array
    following: Array
    """The learner's key in the next epoch."""


def epoch_keys(key: Array) -> EpochKeys:
    """The keys of the epoch that begins with the learner's key."""
    return EpochKeys(*jax.random.split(key, 3))


class Samples(NamedTuple):
    """Flattened transitions of a batch."""

    policy: Array  # [B, f]
    critic: Array  # [B, g]
    noise: Array  # [B, m]
    advantage: Array  # [B] standardised
    target: Array  # [B] of the critic
    weight: Array  # [B]


def make_optimizer(algorithm: Algorithm) -> optax.GradientTransformation:
    """Adam with decoupled weight decay, after clipping the gradient's norm."""
    return optax.chain(
        optax.clip_by_global_norm(algorithm.gradient_norm),
        optax.adamw(_learning_rate(algorithm), weight_decay=algorithm.weight_decay),
    )


def _learning_rate(algorithm: Algorithm) -> optax.ScalarOrSchedule:
    if not algorithm.decay_epochs:
        return algorithm.learning_rate
    steps = algorithm.decay_epochs * algorithm.passes * algorithm.minibatches
    return optax.cosine_decay_schedule(algorithm.learning_rate, steps, alpha=0.02)


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


def flatten(
    algorithm: Algorithm, networks: Networks, parameters: Parameters, batch: Batch
) -> Samples:
    """Advantages and targets of a batch, flattened."""
    value = networks.value(parameters, batch.critic)
    ended = batch.ended.astype(jnp.float32)
    advantage = advantages(batch.reward, value, ended, algorithm.discount, algorithm.trace)
    target = advantage + value[:-1]
    weight = batch.weight / jnp.maximum(batch.weight.mean(), 1e-6)
    mean = (weight * advantage).mean()
    deviation = jnp.sqrt((weight * (advantage - mean) ** 2).mean())
    arrays = (
        batch.policy,
        batch.critic[:-1],
        batch.noise,
        (advantage - mean) / (deviation + 1e-8),
        target,
        weight,
    )
    return Samples(*(a.reshape((-1,) + a.shape[2:]) for a in arrays))


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


def update(state: LearnerState, batch: Batch, *, algorithm: Algorithm) -> LearnerState:
    """One epoch of PPO on a batch, and the elite's update."""
    networks = make_networks(algorithm.hidden, batch.noise.shape[-1])
    optimizer, keys = make_optimizer(algorithm), epoch_keys(state.key)
    samples = flatten(algorithm, networks, state.parameters, batch)
    old_mean = networks.action(state.parameters, samples.policy)
    old_log_std = state.parameters.log_std
    size = samples.weight.shape[0]
    per_minibatch = size // algorithm.minibatches

    def minibatch(carry, index):
        parameters, optimizer_state = carry
        chosen = jax.tree.map(lambda leaf: leaf[index], samples)
        gradient = jax.grad(surrogate)(
            parameters, (old_mean[index], old_log_std), chosen, networks, algorithm.clip
        )
        updates, optimizer_state = optimizer.update(gradient, optimizer_state, parameters)
        return (optax.apply_updates(parameters, updates), optimizer_state), None

    def one_pass(carry, pass_key):
        order = jax.random.permutation(pass_key, size)[: per_minibatch * algorithm.minibatches]
        return jax.lax.scan(minibatch, carry, order.reshape(algorithm.minibatches, -1))

    carry = (state.parameters, state.optimizer)
    (parameters, optimizer_state), _ = jax.lax.scan(
        one_pass, carry, jax.random.split(keys.shuffling, algorithm.passes)
    )
    elite = update_elite(state.elite, batch.schedule, batch.robustness, algorithm.elite_decay)
    return LearnerState(
        cast(Parameters, parameters), optimizer_state, keys.following, batch.chains, elite
    )
