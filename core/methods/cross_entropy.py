"""CEM: the cross-entropy method over the parameters of a policy, robustness as fitness.

App. A.3: in iteration j, draw theta_1, ..., theta_N from N(theta, sigma^2), roll each out, take the
K of the highest robustness and set, parameter by parameter,

    theta' = mean over the elite,    sigma'^2 = sum over the elite (theta_i - theta')^2 / (K - 1)

with N = 512 and K = 32. Here the fitness is the mean robustness from a few initial states, the
same ones for all candidates of an iteration. The policy is deterministic, of state and time;
attempts after the first draw their parameters from the last distribution.

Dimensions: N candidates, S initial states, L steps, A atoms.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from msgspec import Meta

from core.compilation import program, shape_of
from core.documents import Positive
from core.errors import UserError
from core.mdp.episode import is_sound
from core.memory import require_memory
from core.methods.bounds import Size
from core.methods.method import Epoch
from core.methods.networks import ACTOR_GAIN, Perceptron, initial_perceptron, perceptron_shapes
from core.methods.whole_formula.algorithm import WholeFormula
from core.methods.whole_formula.episodes import reward_of, verdicts
from core.methods.whole_formula.features import state_feature_count
from core.methods.whole_formula.method import WholeFormulaMethod
from core.methods.whole_formula.timed import TimedController, drawn_parameters, roll_out_timed
from core.task.problem import Problem, initial_states, trace_margins
from core.task.protocols import Array
from core.task.task import Task


@dataclass(frozen=True)
class CrossEntropy(WholeFormula):
    """Its hyper-parameters."""

    population: Annotated[int, Meta(ge=2, le=2**14)] = 512
    """N."""
    elite: Annotated[int, Meta(ge=2, le=2**14)] = 32
    """K."""
    deviation: Positive = 0.1
    """sigma of the first iteration."""
    starts: Size = 4
    """S."""

    def check(self) -> None:
        """No larger elite than the population."""
        if self.elite > self.population:
            raise UserError(f"elite: {self.elite} must be at most {self.population}")


class Distribution(NamedTuple):
    """A Gaussian for each parameter of the policy."""

    mean: Any
    deviation: Any


class SearchState(NamedTuple):
    """Everything carried from one iteration to the next."""

    distribution: Distribution
    key: Array


class IterationKeys(NamedTuple):
    """Random keys of an iteration by their purpose.

    The candidates are drawn twice, once to be rolled out and once to be averaged: all of them
    would fill more memory than it takes to draw them.
    """

    candidates: Array
    states: Array
    following: Array


class Trials(NamedTuple):
    """Rollouts of all candidates."""

    margins: Array  # [L + 1, N * S, A]
    sound: Array  # [N * S] whether the simulation did not break down


def iteration_keys(key: Array) -> IterationKeys:
    """The keys of the iteration that begins with the search's key."""
    return IterationKeys(*jax.random.split(key, 3))


@program
def _try(
    problem: Problem,
    distribution: Distribution,
    keys: IterationKeys,
    *,
    algorithm: CrossEntropy,
    steps: int,
) -> Trials:
    """Roll out every candidate from the same initial states."""
    states = initial_states(problem, keys.states, count=algorithm.starts)
    candidates = _candidates(distribution, keys, algorithm)

    def from_state(actor: Any, state: Array) -> Array:
        return roll_out_timed(algorithm.hidden, problem, actor, state, steps)

    visited = jax.vmap(jax.vmap(from_state, (None, 0)), (0, None))(candidates, states)
    visited = visited.reshape(-1, *visited.shape[2:])  # [N * S, L + 1, n]
    sound = jax.vmap(is_sound)(visited)
    settled = jnp.where(sound[:, None, None], visited, states[0])
    return Trials(trace_margins(problem, jnp.swapaxes(settled, 0, 1)), sound)


@program
def _select(
    distribution: Distribution, keys: IterationKeys, fitness: Array, *, algorithm: CrossEntropy
) -> Distribution:
    """The distribution of the elite, by the fitness [N] of the candidates."""
    _, best = jax.lax.top_k(fitness, algorithm.elite)
    elite = jax.tree.map(lambda leaf: leaf[best], _candidates(distribution, keys, algorithm))
    return Distribution(
        jax.tree.map(lambda leaf: leaf.mean(0), elite),
        jax.tree.map(lambda leaf: leaf.std(0, ddof=1), elite),
    )


def _candidates(distribution: Distribution, keys: IterationKeys, algorithm: CrossEntropy) -> Any:
    """Parameters of N policies, each leaf [N, ...]."""
    each = jax.random.split(keys.candidates, algorithm.population)
    return jax.vmap(drawn_parameters, (None, None, 0))(*distribution, each)


@dataclass(frozen=True)
class CrossEntropyLearner:
    """Searches on one task, in the robot's model where it has a true physics besides."""

    task: Task
    algorithm: CrossEntropy

    @property
    def steps_per_epoch(self) -> int:
        """N times S times L."""
        return self.algorithm.population * self.algorithm.starts * self.task.padded_horizon

    @property
    def evaluation_states(self) -> int:
        """Initial states of an evaluation while training."""
        return self.algorithm.evaluation_states

    @property
    def pace_change(self) -> None:
        """Iterations do not change."""
        return None

    def _draw_attempts(self, distribution: Distribution) -> int:
        """Draw what evaluations draw, so that none of them waits for a compilation."""
        return len(self.controller(distribution).attempts)

    @property
    def _network(self) -> Perceptron:
        return Perceptron(self.algorithm.hidden, self.task.robot.action_size)

    def fresh(self, seed: int) -> SearchState:
        """The first distribution, around a policy that hardly acts."""
        count, random = state_feature_count(self.task.problem), np.random.default_rng(seed)
        mean = initial_perceptron(self._network, count, ACTOR_GAIN, random)
        deviation = jax.tree.map(lambda leaf: jnp.full_like(leaf, self.algorithm.deviation), mean)
        key = jax.random.fold_in(jax.random.key(seed), 0)
        return SearchState(Distribution(mean, deviation), key)

    def jobs(self, state: SearchState) -> list[Callable[[], Any]]:
        """Compilations that iterations need.

        Raises:
            UserError: an iteration takes more memory than is free.
        """
        keys, steps = iteration_keys(state.key), self.task.padded_horizon
        trying = self.task.problem, state.distribution, keys
        trials = _try.shapes(*trying, algorithm=self.algorithm, steps=steps)
        require_memory(trials, steps, self.algorithm.population * self.algorithm.starts)
        fitness = shape_of(self.algorithm.population, dtype=jnp.float32)
        chosen = state.distribution, keys, fitness
        return [
            partial(_try.compile, *trying, algorithm=self.algorithm, steps=steps),
            partial(_select.compile, *chosen, algorithm=self.algorithm),
            partial(self._draw_attempts, state.distribution),
        ]

    def epoch(self, state: SearchState, number: int) -> tuple[SearchState, Epoch]:
        """One iteration."""
        del number
        keys, steps = iteration_keys(state.key), self.task.padded_horizon
        trials = _try(
            self.task.problem, state.distribution, keys, algorithm=self.algorithm, steps=steps
        )
        verdict = verdicts(self.task, trials.margins, trials.sound)
        earned = reward_of(self.task, verdict)
        fitness = jnp.asarray(earned.reshape(self.algorithm.population, -1).mean(1))
        distribution = _select(state.distribution, keys, fitness, algorithm=self.algorithm)
        broken = int((~np.asarray(trials.sound)).sum())
        return SearchState(distribution, keys.following), Epoch(
            float((verdict >= 0).mean()), float(earned.mean()) / self.task.horizon, broken
        )

    def weight_shapes(self) -> Distribution:
        """Stands for the weights of any state."""
        shapes = perceptron_shapes(self._network, state_feature_count(self.task.problem))
        return Distribution(shapes, shapes)

    def weights(self, state: SearchState) -> Distribution:
        """The distribution of the policy's parameters."""
        return state.distribution

    def with_weights(self, state: SearchState, weights: Distribution) -> SearchState:
        """The state with another mean; it explores as at the start."""
        return state._replace(distribution=state.distribution._replace(mean=weights.mean))

    def controller(self, weights: Distribution) -> TimedController:
        """The mean policy, of which later attempts are drawn."""
        return _controller(self.algorithm, weights)


def _controller(algorithm: CrossEntropy, weights: Distribution) -> TimedController:
    return TimedController(algorithm.hidden, weights.mean, weights.deviation)


CEM = WholeFormulaMethod(
    "cem",
    "CEM (cross-entropy method)",
    CrossEntropy(),
    CrossEntropy(mode="paper", hidden=(512, 512, 512)),
    CrossEntropyLearner,
    _controller,
)
