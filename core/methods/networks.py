"""Actor and critic: two separate perceptrons, and a Gaussian over normalised actions."""

from typing import Any, NamedTuple, Protocol

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import shape_of
from core.task.problem import Problem
from core.task.protocols import Array

ACTOR_GAIN = 0.01
"""Gain of the actor's last layer: at first all actions are near zero."""


class Perceptron(nn.Module):
    """Multi-layer perceptron with tanh units."""

    hidden: tuple[int, ...]
    outputs: int

    @nn.compact
    def __call__(self, inputs: Array) -> Array:
        """Map features [..., f] to outputs [..., o]."""
        hidden = inputs
        for size in self.hidden:
            hidden = jnp.tanh(nn.Dense(size)(hidden))
        return nn.Dense(self.outputs)(hidden)


class Parameters(NamedTuple):
    """Weights of the networks and the logarithm of the actions' standard deviation [m]."""

    actor: Any
    critic: Any
    log_std: Array
    outcome: Any = None
    """TGPO's critic of outcomes of weights that serve every task (see `tgpo.outcome`)."""


class Networks(NamedTuple):
    """The two networks (static)."""

    actor: Perceptron
    critic: Perceptron

    def initial(self, seed: int, policy_size: int, critic_size: int, log_std: float) -> Parameters:
        """Fresh parameters for the given numbers of features.

        Orthogonal weights with gain sqrt(2) (0.01 for the actor's last layer, 1 for the
        critic's), made on the host: compiling their factorisation would take seconds.
        """
        random = np.random.default_rng(seed)
        return Parameters(
            initial_perceptron(self.actor, policy_size, ACTOR_GAIN, random),
            initial_perceptron(self.critic, critic_size, 1.0, random),
            jnp.full(self.actor.outputs, log_std, jnp.float32),
        )

    def shapes(self, policy_size: int, critic_size: int) -> Parameters:
        """Stands for `initial`, without making it."""
        return Parameters(
            perceptron_shapes(self.actor, policy_size),
            perceptron_shapes(self.critic, critic_size),
            shape_of(self.actor.outputs, dtype=jnp.float32),
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
    return Networks(Perceptron(hidden, action_size), Perceptron(hidden, 1))


class Sized(Protocol):
    """Hyper-parameters that say how large networks are."""

    @property
    def hidden(self) -> tuple[int, ...]:
        """Units of each hidden layer."""
        ...


def networks_of(algorithm: Sized, problem: Problem) -> Networks:
    """The networks of an algorithm for the robot of a problem."""
    return make_networks(algorithm.hidden, problem.robot.action_size)


def perceptron_shapes(network: Perceptron, inputs: int) -> Any:
    """Stands for the parameters of a perceptron."""
    return jax.eval_shape(network.init, jax.random.key(0), shape_of(inputs, dtype=jnp.float32))


def initial_perceptron(
    network: Perceptron, inputs: int, last_gain: float, random: np.random.Generator
) -> Any:
    """Parameters of a perceptron with orthogonal kernels and zero biases."""
    shapes = perceptron_shapes(network, inputs)
    last = f"Dense_{len(network.hidden)}"
    layers = {}
    for name, layer in sorted(shapes["params"].items()):
        rows, columns = layer["kernel"].shape
        gain = last_gain if name == last else 2**0.5
        layers[name] = {
            "kernel": jnp.asarray(gain * orthogonal(rows, columns, random), jnp.float32),
            "bias": jnp.zeros(columns, jnp.float32),
        }
    return {"params": layers}


def orthogonal(rows: int, columns: int, random: np.random.Generator) -> np.ndarray:
    """A random matrix [rows, columns] with orthonormal rows or columns, whichever are fewer."""
    square = random.normal(size=(max(rows, columns), min(rows, columns)))
    factor, triangle = np.linalg.qr(square)
    factor = factor * np.sign(np.diag(triangle))
    return factor if rows >= columns else factor.T
