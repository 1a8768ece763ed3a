"""Training as a generator: `for progress in train(task, config): ...`.

The command line, the page and the tests consume the same iterator; who stops iterating has
stopped the training. Epochs are deterministic in the seed, whenever the caller looks. What a
method learns is its own affair (see `core.methods.method`): evaluations, budget and best weights
are kept here, the same for all.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import compile_together
from core.controller import Controller
from core.evaluation import EVALUATION_STATES, Evaluation, evaluate, evaluate_layouts
from core.failures import commonest_failure, failure_text
from core.methods import METHODS
from core.methods.method import Learner
from core.rollout import rollout_jobs
from core.task.protocols import Array
from core.task.task import Task


@dataclass(frozen=True)
class TrainingConfig:
    """What a run is asked for."""

    algorithm: Any
    """Hyper-parameters, from `METHODS[method].preset`."""
    method: str = "tgpo-star"
    seed: int = 1007
    epochs: int = 200
    """Most epochs to train."""
    time_limit: float = float("inf")
    """Most seconds to train, compilation apart."""
    target: float = 0.995
    """Stop at an evaluation of at least this success rate; above 1 trains to the end."""
    evaluate_every: int = 5
    """Epochs between evaluations."""
    warm: bool = False
    """Whether the training goes on from weights learnt elsewhere (`state_from_weights`).

    Where they do not lead anywhere, it begins anew from scratch (see `STALLED`)."""

    def controller(self, weights: Any) -> Controller:
        """The controller of weights that were learnt with this configuration."""
        return METHODS[self.method].controller(self.algorithm, weights)

    def learner(self, task: Task, epoch: int = 1) -> Learner:
        """What learns, from an epoch on."""
        return METHODS[self.method].learner(task, self.algorithm, epoch)


STALLED = 0.5
"""Success rate that a warm training must reach within `PATIENCE` epochs to go on."""

PATIENCE = 10
"""Epochs; shipped tasks that need any training from the weights take 2 to 8."""


class RunState(NamedTuple):
    """All that a run carries from epoch to epoch: a checkpoint's content."""

    learner: Any  # the learner's state
    best: Any  # weights
    best_success: Array  # [] of the evaluation that chose `best`, -1 before the first
    best_robustness: Array  # []
    epoch: Array  # [] epochs finished
    seconds: Array  # [] spent in training
    finished: Array  # [] whether the target was reached


@dataclass(frozen=True)
class Progress:
    """What is known after an epoch."""

    epoch: int
    env_steps: int
    train_seconds: float
    compile_seconds: float
    cpu_seconds: float
    """Processor seconds of all threads of this process, since the first of these epochs began."""
    batch_success: float
    """Share of the epoch's first episodes, as they were explored, that succeeded."""
    batch_return: float
    """Mean reward per step."""
    diverged: int
    """Simulations of the epoch that broke down; their episodes count as failed."""
    schedules: np.ndarray | None
    """Schedules [C, V] that the search for times stands at, if there is one."""
    evaluation: Evaluation | None
    """The evaluation made after this epoch, if one was due."""
    weights: Any
    """Weights after this epoch."""
    state: RunState
    """Immutable; what a checkpoint keeps."""


def train(task: Task, config: TrainingConfig, resume: RunState | None = None) -> Iterator[Progress]:
    """Train a controller; yields after every epoch.

    Args:
        task: the grounded task.
        config: method, hyper-parameters and budget.
        resume: state of an earlier run of the same task and configuration; what follows is what
            the uninterrupted run would have given.
    """
    state = resume if resume is not None else fresh_state(task, config)
    learner = config.learner(task, int(state.epoch) + 1)
    controller = learner.controller(learner.weights(state.learner))
    compile_seconds = compile_together(
        *learner.jobs(state.learner), *rollout_jobs(task, controller, learner.evaluation_states)
    )
    began, cpu_began = time.perf_counter() - float(state.seconds), time.process_time()
    while not _done(state, config, began):
        number = int(state.epoch) + 1
        learnt, epoch = learner.epoch(state.learner, number)
        weights, evaluation = learner.weights(learnt), None
        if number % config.evaluate_every == 0 or number == config.epochs:
            evaluation = evaluate_layouts(
                task,
                learner.controller(weights),
                _evaluation_key(config, number),
                count=learner.evaluation_states,
            )
        jax.block_until_ready(learnt)
        state = state._replace(
            learner=learnt,
            epoch=jnp.int32(number),
            seconds=jnp.float32(time.perf_counter() - began),
        )
        state = _with_best(state, weights, evaluation, config.target)
        if config.warm and number == PATIENCE and float(state.best_success) < STALLED:
            state = state._replace(learner=learner.fresh(config.seed))
        yield Progress(
            number,
            number * learner.steps_per_epoch,
            float(state.seconds),
            compile_seconds,
            time.process_time() - cpu_began,
            epoch.success,
            epoch.mean_reward,
            epoch.diverged,
            epoch.schedules,
            evaluation,
            weights,
            state,
        )


def fresh_state(task: Task, config: TrainingConfig) -> RunState:
    """State before the first epoch; nothing is compiled."""
    learner = config.learner(task)
    state = learner.fresh(config.seed)
    return RunState(
        state,
        learner.weights(state),
        jnp.float32(-1),
        jnp.float32(-jnp.inf),
        jnp.int32(0),
        jnp.float32(0),
        jnp.bool_(False),
    )


def state_from_weights(task: Task, config: TrainingConfig, weights: Any) -> RunState:
    """State before the first epoch of a training that goes on from weights learnt elsewhere.

    The weights count as the best until an evaluation says otherwise.
    """
    state = fresh_state(task, config)
    learner = config.learner(task)
    learnt = learner.with_weights(state.learner, weights)
    return state._replace(learner=learnt, best=learner.weights(learnt))


def latest_weights(task: Task, config: TrainingConfig, state: RunState) -> Any:
    """Weights after the last epoch."""
    return config.learner(task).weights(state.learner)


def best_weights(task: Task, config: TrainingConfig, state: RunState) -> Any:
    """Weights of the best evaluation; the latest ones before the first evaluation."""
    if float(state.best_success) >= 0:
        return state.best
    return latest_weights(task, config, state)


def final_evaluation(task: Task, config: TrainingConfig, weights: Any) -> Evaluation:
    """Evaluation on initial states that no evaluation during training has seen.

    It looks between the steps, too.
    """
    controller, key = config.controller(weights), _evaluation_key(config, 0)
    return evaluate(task, controller, key, between=True)


def what_fails(
    task: Task, config: TrainingConfig, weights: Any, *, count: int = EVALUATION_STATES
) -> str:
    """The task that fails most often with some weights, in words; empty if none does.

    Empty for a method that chooses no times, too: tasks have no windows without them.

    Args:
        task: what was trained on.
        config: of the training.
        weights: what it has learnt.
        count: rollouts that are looked at.
    """
    controller = config.controller(weights)
    if controller.search is None:
        return ""
    failure = commonest_failure(task, controller, _evaluation_key(config, 0), count=count)
    return "" if failure is None else failure_text(task, failure)


def _evaluation_key(config: TrainingConfig, epoch: int) -> Array:
    """The random key of the evaluation after an epoch, or of the final one (epoch 0)."""
    return jax.random.fold_in(jax.random.key(config.seed), 2**20 + epoch)


def _done(state: RunState, config: TrainingConfig, began: float) -> bool:
    spent = time.perf_counter() - began
    return bool(state.finished) or int(state.epoch) >= config.epochs or spent >= config.time_limit


def _with_best(
    state: RunState, weights: Any, evaluation: Evaluation | None, target: float
) -> RunState:
    if evaluation is None:
        return state
    score = (evaluation.success_rate, evaluation.robustness_mean)
    if score < (float(state.best_success), float(state.best_robustness)):
        return state
    return state._replace(
        best=weights,
        best_success=jnp.float32(score[0]),
        best_robustness=jnp.float32(score[1]),
        finished=jnp.bool_(score[0] >= target),
    )
