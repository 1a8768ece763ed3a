"""Proximal policy optimisation of the gait (Schulman et al. 2017), compiled by JAX.

Dimensions: L steps, N ants, B = L * N transitions.
"""

from functools import partial
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
import optax

HIDDEN = (128, 128)
MINIBATCH, PASSES = 2048, 5
DISCOUNT, TRACE, CLIP, ENTROPY = 0.98, 0.95, 0.2, 0.002
KL = 0.012
"""Divergence of an update that the learning rate is steered to."""
RATES = (5e-5, 2e-3)

OPTIMIZER = optax.inject_hyperparams(
    lambda learning_rate: optax.chain(
        optax.clip_by_global_norm(1.0), optax.adam(learning_rate, eps=1e-5)
    )
)(learning_rate=5e-4)


class Weights(NamedTuple):
    """Actor and critic: lists of (weights, bias); log deviation of the actions [8]."""

    actor: Any
    critic: Any
    log_std: Any


class Samples(NamedTuple):
    """Flattened transitions."""

    observation: Any  # [B, 29] normalised
    action: Any  # [B, 8]
    mean: Any  # [B, 8] of the policy that acted
    advantage: Any  # [B]
    target: Any  # [B] of the critic


def initial_weights(seed: int, features: int, actions: int) -> Weights:
    """Orthogonal weights, the actor's last layer near zero."""
    actor_key, critic_key = jax.random.split(jax.random.key(seed))
    return Weights(
        _layers(actor_key, (features, *HIDDEN, actions), 0.01),
        _layers(critic_key, (features, *HIDDEN, 1), 1.0),
        jnp.full(actions, -0.5),
    )


def _layers(key: Any, sizes: tuple[int, ...], last: float) -> list:
    made = []
    for index, (inputs, outputs) in enumerate(zip(sizes[:-1], sizes[1:], strict=True)):
        key, layer_key = jax.random.split(key)
        scale = last if index == len(sizes) - 2 else np.sqrt(2)
        weights = jax.nn.initializers.orthogonal(scale)(layer_key, (inputs, outputs))
        made.append((weights, jnp.zeros(outputs)))
    return made


def network(layers: Any, value: Any) -> Any:
    """Outputs of a network of tanh layers."""
    for weights, bias in layers[:-1]:
        value = jnp.tanh(value @ weights + bias)
    return value @ layers[-1][0] + layers[-1][1]


@jax.jit
def look(weights: Weights, observation: Any) -> tuple[Any, Any]:
    """Mean actions [N, 8] and values [N]."""
    return network(weights.actor, observation), network(weights.critic, observation)[:, 0]


def advantages(reward, value, over) -> np.ndarray:
    """Generalised advantage estimates [L, N] of rewards [L, N] and values [L + 1, N]."""
    estimate, running = np.zeros_like(reward), np.zeros(reward.shape[1])
    for t in range(len(reward) - 1, -1, -1):
        error = reward[t] + DISCOUNT * value[t + 1] * (1 - over[t]) - value[t]
        running = error + DISCOUNT * TRACE * (1 - over[t]) * running
        estimate[t] = running
    return estimate


@partial(jax.jit, donate_argnums=(0, 1))
def update(weights: Weights, optimizer: Any, samples: Samples, order: Any, rate: Any):
    """Passes over the samples in the given order [K, MINIBATCH]; also the final divergence."""
    optimizer.hyperparams["learning_rate"] = rate
    old = weights.log_std

    def one(carry, index):
        weights, optimizer = carry
        part = jax.tree.map(lambda leaf: leaf[index], samples)
        (_, divergence), gradient = jax.value_and_grad(_loss, has_aux=True)(weights, part, old)
        change, optimizer = OPTIMIZER.update(gradient, optimizer, weights)
        return (cast(Weights, optax.apply_updates(weights, change)), optimizer), divergence

    (weights, optimizer), divergence = jax.lax.scan(one, (weights, optimizer), order)
    return weights, optimizer, divergence[-4:].mean()


def _loss(weights: Weights, samples: Samples, old: Any) -> tuple[Any, Any]:
    mean, value = look(weights, samples.observation)
    log_std = weights.log_std

    def log_density(center, scale):
        return (-0.5 * ((samples.action - center) / jnp.exp(scale)) ** 2 - scale).sum(-1)

    ratio = jnp.exp(log_density(mean, log_std) - log_density(samples.mean, old))
    advantage = samples.advantage
    advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-6)
    gain = jnp.minimum(ratio * advantage, jnp.clip(ratio, 1 - CLIP, 1 + CLIP) * advantage)
    error = 0.5 * ((value - samples.target) ** 2).mean()
    moved = (jnp.exp(2 * old) + (mean - samples.mean) ** 2) / (2 * jnp.exp(2 * log_std))
    divergence = (log_std - old + moved - 0.5).sum(-1).mean()
    return error - gain.mean() - ENTROPY * log_std.sum(), divergence


def steered(rate: float, divergence: float) -> float:
    """The next learning rate."""
    if divergence > 1.5 * KL:
        return max(rate / 1.3, RATES[0])
    return min(rate * 1.3, RATES[1]) if divergence < KL / 1.5 else rate
