"""The controller of a deterministic policy of state and time: u = tanh(actor(x, k / T)).

It sees nothing of the history but the time (App. A.3, "Grad").
"""

from dataclasses import dataclass, field, replace
from typing import Any

import jax
import jax.numpy as jnp

from core.compilation import program
from core.methods.networks import Perceptron
from core.methods.whole_formula.controller import ATTEMPTS
from core.methods.whole_formula.features import state_features
from core.task.problem import Problem
from core.task.protocols import Array


def timed_action(
    hidden: tuple[int, ...], problem: Problem, actor: Any, state: Array, tau: Array
) -> Array:
    """Action [m] in a state [n] at a step."""
    network = Perceptron(hidden, problem.robot.action_size)
    output: Any = network.apply(actor, state_features(problem, state, tau))
    return jnp.tanh(output)


def roll_out_timed(
    hidden: tuple[int, ...], problem: Problem, actor: Any, state: Array, steps: int
) -> Array:
    """States [L + 1, n] from an initial state [n], in the robot's model."""

    def step(state: Array, tau: Array) -> tuple[Array, Array]:
        after = problem.robot.step(state, timed_action(hidden, problem, actor, state, tau))
        return after, after

    _, visited = jax.lax.scan(step, state, jnp.arange(steps))
    return jnp.concatenate([state[None], visited])


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class TimedController:
    """Carries out the formula as a whole (see `core.controller`).

    Attributes:
        hidden: Units of each hidden layer.
        actor: Parameters of the policy.
        spread: Standard deviation of each parameter, of which further attempts are drawn; None
            where all attempts would be the same.
    """

    hidden: tuple[int, ...] = field(metadata={"static": True})
    actor: Any
    spread: Any = None

    @property
    def search(self) -> None:
        """It chooses no times."""
        return None

    @property
    def attempts(self) -> tuple["TimedController", ...]:
        """Ten where parameters are drawn, or itself."""
        if self.spread is None:
            return (self,)
        keys = jax.random.split(jax.random.key(0), ATTEMPTS - 1)
        drawn = (replace(self, actor=_drawn(self.actor, self.spread, key)) for key in keys)
        return (self, *drawn)

    def score(self, problem: Problem, state: Array, schedule: Array) -> Array:
        """Nothing is promised of a schedule."""
        del problem, state, schedule
        return jnp.zeros(())

    def start(self, problem: Problem, state: Array, schedule: Array) -> Array:
        """The first step."""
        del problem, state, schedule
        return jnp.zeros((), jnp.int32)

    def step(self, problem: Problem, memory: Array, state: Array) -> tuple[Array, Array]:
        """The action [m] for a measured state [n]."""
        return memory + 1, timed_action(self.hidden, problem, self.actor, state, memory)


def drawn_parameters(mean: Any, deviation: Any, key: Array) -> Any:
    """Parameters of which each is drawn from a Gaussian of its own."""
    leaves, structure = jax.tree.flatten(mean)
    keys = jax.tree.unflatten(structure, list(jax.random.split(key, len(leaves))))
    return jax.tree.map(
        lambda m, d, leaf_key: m + d * jax.random.normal(leaf_key, m.shape), mean, deviation, keys
    )


_drawn = program(drawn_parameters)
