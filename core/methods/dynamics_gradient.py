"""Grad: backpropagation through the dynamics, by a smooth robustness.

App. A.3 (after Leung and Pavone 2022; Meng and Fan 2023): a deterministic policy of state and time
is rolled out in the robot's model, and its parameters climb the gradient of

    J(theta) = mean over initial states of rho~(x_0, ..., x_T),

rho~ the robustness with log-sum-exp for max (Pant et al. 2017), through all T steps of the
dynamics. The model is the robot's own `step`: a robot that is simulated in a true physics, the ant,
learns in its fast model and is judged in the truth.

The formula is part of the compiled program: another formula is compiled anew.

Dimensions: N initial states, L steps, A atoms.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax

from core.compilation import Program
from core.documents import NotNegative, Positive
from core.errors import UserError
from core.mdp.episode import is_sound
from core.memory import require_memory
from core.methods.bounds import Many, Size
from core.methods.method import Epoch
from core.methods.networks import ACTOR_GAIN, Perceptron, initial_perceptron, perceptron_shapes
from core.methods.whole_formula.algorithm import WholeFormula
from core.methods.whole_formula.episodes import reward_of, verdicts
from core.methods.whole_formula.features import state_feature_count
from core.methods.whole_formula.method import WholeFormulaMethod
from core.methods.whole_formula.timed import TimedController, roll_out_timed
from core.stl import Formula, smooth_robustness
from core.task.problem import Problem, initial_states, trace_margins
from core.task.protocols import Array
from core.task.task import Task


@dataclass(frozen=True)
class DynamicsGradient(WholeFormula):
    """Its hyper-parameters."""

    environments: Many = 512
    """N, rollouts of an epoch."""
    minibatches: Size = 8
    """Steps of Adam in an epoch, each on a part of the rollouts."""
    learning_rate: Positive = 2e-3
    weight_decay: NotNegative = 0.0
    gradient_norm: Positive = 0.5
    temperature: Positive = 0.1
    """Of the smooth robustness, in robot lengths."""

    def check(self) -> None:
        """No more minibatches than rollouts."""
        if self.minibatches > self.environments:
            raise UserError(
                f"minibatches: {self.minibatches} must be at most {self.environments}, the "
                "number of environments"
            )

    def optimizer(self) -> optax.GradientTransformation:
        """Adam with decoupled weight decay, after clipping the gradient's norm."""
        return optax.chain(
            optax.clip_by_global_norm(self.gradient_norm),
            optax.adamw(self.learning_rate, weight_decay=self.weight_decay),
        )


class ClimbState(NamedTuple):
    """Everything carried from one epoch to the next."""

    actor: Any
    optimizer: Any
    key: Array


class Climbed(NamedTuple):
    """An epoch's rollouts, those of each minibatch by the policy before its step."""

    margins: Array  # [L + 1, N, A]
    sound: Array  # [N] whether the simulation did not break down


class EpochKeys(NamedTuple):
    """Random keys of an epoch by their purpose; each is used once."""

    states: Array
    following: Array


def epoch_keys(key: Array) -> EpochKeys:
    """The keys of the epoch that begins with the learner's key."""
    return EpochKeys(*jax.random.split(key, 2))


def climb(
    problem: Problem,
    state: ClimbState,
    *,
    algorithm: DynamicsGradient,
    formula: Formula,
    names: tuple[str, ...],
    steps: int,
) -> tuple[ClimbState, Climbed]:
    """One epoch of gradient steps.

    Args:
        problem: the grounded task.
        state: before the epoch.
        algorithm: hyper-parameters.
        formula: what is to be satisfied.
        names: of the atoms, in the order of the margins.
        steps: L.
    """
    keys, length = epoch_keys(state.key), problem.robot.length
    optimizer, parts = algorithm.optimizer(), algorithm.minibatches
    count = algorithm.environments // parts
    states = initial_states(problem, keys.states, count=count * parts)

    def loss(actor: Any, states: Array) -> tuple[Array, Climbed]:
        roll_out = partial(roll_out_timed, algorithm.hidden, problem, actor, steps=steps)
        visited = jax.vmap(lambda start: roll_out(state=start))(states)
        margins = trace_margins(problem, jnp.swapaxes(visited, 0, 1))
        traces = jnp.swapaxes(margins, 0, 1) / length
        score = smooth_robustness(formula, traces, names, algorithm.temperature)
        sound = jax.vmap(is_sound)(visited)
        return -jnp.where(sound, score, 0.0).mean(), Climbed(margins, sound)

    def step(carry: tuple[Any, Any], states: Array):
        actor, optimizer_state = carry
        gradient, climbed = jax.grad(loss, has_aux=True)(actor, states)
        finite = jnp.stack([jnp.isfinite(leaf).all() for leaf in jax.tree.leaves(gradient)]).all()
        gradient = jax.tree.map(lambda leaf: jnp.where(finite, leaf, 0.0), gradient)
        updates, optimizer_state = optimizer.update(gradient, optimizer_state, actor)
        return (optax.apply_updates(actor, updates), optimizer_state), climbed

    carry = state.actor, state.optimizer
    dealt = states.reshape(parts, count, -1)
    (actor, optimizer_state), climbed = jax.lax.scan(step, carry, dealt)
    margins = jnp.moveaxis(climbed.margins, 0, 1)  # [L + 1, parts, count, A]
    margins = margins.reshape(steps + 1, count * parts, -1)
    following = ClimbState(actor, optimizer_state, keys.following)
    return following, Climbed(margins, climbed.sound.reshape(-1))


_climb = Program(climb, fused=True)


@dataclass(frozen=True)
class GradientLearner:
    """Climbs on one task, in the robot's model where it has a true physics besides."""

    task: Task
    algorithm: DynamicsGradient

    @property
    def steps_per_epoch(self) -> int:
        """N times L."""
        return self.algorithm.environments * self.task.padded_horizon

    @property
    def evaluation_states(self) -> int:
        """Initial states of an evaluation while training."""
        return self.algorithm.evaluation_states

    @property
    def pace_change(self) -> None:
        """Epochs do not change."""
        return None

    @property
    def _network(self) -> Perceptron:
        return Perceptron(self.algorithm.hidden, self.task.robot.action_size)

    @property
    def _static(self) -> dict[str, Any]:
        return {
            "algorithm": self.algorithm,
            "formula": self.task.formula,
            "names": self.task.grounding.atoms,
            "steps": self.task.padded_horizon,
        }

    def fresh(self, seed: int) -> ClimbState:
        """A policy that hardly acts."""
        count, random = state_feature_count(self.task.problem), np.random.default_rng(seed)
        actor = initial_perceptron(self._network, count, ACTOR_GAIN, random)
        key = jax.random.fold_in(jax.random.key(seed), 0)
        return ClimbState(actor, self.algorithm.optimizer().init(actor), key)

    def jobs(self, state: ClimbState) -> list[Callable[[], Any]]:
        """Compilations that epochs need.

        Raises:
            UserError: an epoch takes more memory than is free.
        """
        _, climbed = _climb.shapes(self.task.problem, state, **self._static)
        require_memory(climbed, self.task.padded_horizon, self.algorithm.environments)
        return [partial(_climb.compile, self.task.problem, state, **self._static)]

    def epoch(self, state: ClimbState, number: int) -> tuple[ClimbState, Epoch]:
        """Gradient steps on N rollouts."""
        del number
        following, climbed = _climb(self.task.problem, state, **self._static)
        verdict = verdicts(self.task, climbed.margins, climbed.sound)
        earned = float(reward_of(self.task, verdict).mean()) / self.task.horizon
        broken = int((~np.asarray(climbed.sound)).sum())
        return following, Epoch(float((verdict >= 0).mean()), earned, broken)

    def weight_shapes(self) -> Any:
        """Stands for the parameters of the policy."""
        return perceptron_shapes(self._network, state_feature_count(self.task.problem))

    def weights(self, state: ClimbState) -> Any:
        """Parameters of the policy."""
        return state.actor

    def with_weights(self, state: ClimbState, weights: Any) -> ClimbState:
        """The state with another policy."""
        return state._replace(actor=weights)

    def controller(self, weights: Any) -> TimedController:
        """The policy; all attempts would be the same."""
        return _controller(self.algorithm, weights)


def _controller(algorithm: DynamicsGradient, weights: Any) -> TimedController:
    return TimedController(algorithm.hidden, weights)


GRAD = WholeFormulaMethod(
    "grad",
    "Grad (gradient through the robot's model)",
    DynamicsGradient(),
    DynamicsGradient(
        mode="paper",
        hidden=(512, 512, 512),
        minibatches=1,
        learning_rate=3e-4,
        weight_decay=0.1,
    ),
    GradientLearner,
    _controller,
)
