"""Actor and critic: two separate perceptrons, and a Gaussian over normalised actions."""

from typing import Any, NamedTuple

import flax.linen as nn
import jax
import jax.numpy as jnp

from core.protocols import Array


class Perceptron(nn.Module):
    """Multi-layer perceptron with tanh units and orthogonal initial weights."""

    hidden: tuple[int, ...]
    outputs: int
    output_scale: float

    @nn.compact
    def __call__(self, inputs: Array) -> Array:
        """Map features [..., f] to outputs [..., o]."""
        hidden = inputs
        for size in self.hidden:
            weights = nn.initializers.orthogonal(2**0.5)
            hidden = jnp.tanh(nn.Dense(size, kernel_init=weights)(hidden))
        last = nn.initializers.orthogonal(self.output_scale)
        return nn.Dense(self.outputs, kernel_init=last)(hidden)


class Parameters(NamedTuple):
    """Weights of both networks and the logarithm of the actions' standard deviation [m]."""

    actor: Any
    critic: Any
    log_std: Array


class Networks(NamedTuple):
    """The two networks (static)."""

    actor: Perceptron
    critic: Perceptron

    def initial(self, key: Array, policy_size: int, critic_size: int, log_std: float) -> Parameters:
        """Fresh parameters for the given numbers of features."""
        actor_key, critic_key = jax.random.split(key)
        return Parameters(
            self.actor.init(actor_key, jnp.zeros(policy_size)),
            self.critic.init(critic_key, jnp.zeros(critic_size)),
            jnp.full(self.actor.outputs, log_std),
        )

    def action(self, parameters: Parameters, features: Array) -> Array:
        """Mean action [..., m]."""
        return self.actor.apply(parameters.actor, features)  # pyright: ignore[reportReturnType]

    def value(self, parameters: Parameters, features: Array) -> Array:
        """Value [...] in units of the scaled reward."""
        value: Any = self.critic.apply(parameters.critic, features)
        return value[..., 0]


def make_networks(hidden: tuple[int, ...], action_size: int) -> Networks:
    """Actor and critic with the same hidden layers."""
    return Networks(Perceptron(hidden, action_size, 0.01), Perceptron(hidden, 1, 1.0))
