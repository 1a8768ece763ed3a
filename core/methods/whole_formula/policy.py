"""What a policy with a memory is, which acts on the whole formula and learns by PPO.

The three baselines that learn by PPO differ in what they remember of the history: all of it
(tau-MDP), what a recurrent network keeps (RNN), or a flag for each subformula (F-MDP).

Dimensions: L steps, N environments, f what is seen, m action.
"""

from typing import Any, NamedTuple, Protocol

from core.methods.networks import Parameters
from core.methods.ppo import Transitions
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.task import Task


class PolicyWeights(NamedTuple):
    """What a policy acts with."""

    heads: Parameters
    """Actor and critic, and how much actions vary."""
    memory: Any
    """What its memory works with: learnt parameters, or the formula's own numbers."""


class Acted(NamedTuple):
    """What a policy does at one step."""

    memory: Any
    seen: Array  # [f] from which, with the weights, all else can be learnt
    paid: Array  # [] reward for having come here, in units of the robot's length
    mean: Array  # [m] mean action


class Policy(Protocol):
    """A hashable value; `start` and `act` treat one episode, and can be traced by JAX."""

    def initial(self, task: Task, algorithm: Any, seed: int) -> PolicyWeights:
        """Fresh weights, made on the host.

        Raises:
            UserError: the formula is outside of what the method knows.
        """
        ...

    def shapes(self, task: Task) -> PolicyWeights:
        """Stands for the weights; nothing of their size is made.

        Raises:
            UserError: as `initial`.
        """
        ...

    def start(self, problem: Problem, weights: PolicyWeights, state: Array) -> Any:
        """Memory before the first step of an episode from a state [n]."""
        ...

    def act(self, problem: Problem, weights: PolicyWeights, memory: Any, state: Array) -> Acted:
        """The step in a state [n]; the first is the initial one."""
        ...

    def learnable(self, weights: PolicyWeights) -> Any:
        """The part of the weights that is learnt: a pytree."""
        ...

    def learn(
        self,
        algorithm: Any,
        weights: PolicyWeights,
        optimizer: Any,
        transitions: Transitions,
        key: Array,
    ) -> tuple[PolicyWeights, Any]:
        """One epoch of PPO on what was seen: new weights and state of the optimiser.

        `transitions` holds what was seen as the features of both networks.
        """
        ...
