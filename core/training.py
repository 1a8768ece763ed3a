"""Training as a generator: `for progress in train(task, config): ...`.

The command line, the page and the tests consume the same iterator; who stops iterating has
stopped the training. Epochs are deterministic in the seed, whenever the caller looks.
"""

import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import cache
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.algorithm import Algorithm
from core.collection import Batch
from core.evaluation import Evaluation, evaluate, evaluate_layouts, trace_robustness
from core.layouts import epoch_problems
from core.learner import LearnerState
from core.networks import Parameters
from core.paper_mode import PaperMode
from core.problem import Problem
from core.programs import (
    TrainingPrograms,
    evaluation_programs,
    fresh_learner,
    training_programs,
)
from core.protocols import Array, World
from core.task import Task


@dataclass(frozen=True)
class TrainingConfig:
    """What a run is asked for."""

    algorithm: Algorithm = field(default_factory=Algorithm)
    seed: int = 1007
    epochs: int = 200
    """Most epochs to train."""
    time_limit: float = float("inf")
    """Most seconds to train, compilation apart."""
    target: float = 0.995
    """Stop at an evaluation of at least this success rate; above 1 trains to the end."""
    evaluate_every: int = 5
    """Epochs between evaluations."""


class RunState(NamedTuple):
    """All that a run carries from epoch to epoch: a checkpoint's content."""

    learner: LearnerState
    best: Parameters
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
    batch_success: float
    """Share of the epoch's first episodes (noisy actions, mixed schedules) that succeeded."""
    batch_return: float
    """Mean reward per step."""
    diverged: int
    """Simulations of the epoch that broke down; their episodes count as failed."""
    evaluation: Evaluation | None
    """The evaluation made after this epoch, if one was due."""
    state: RunState
    """Immutable; what a checkpoint keeps."""

    @property
    def parameters(self) -> Parameters:
        """Weights after this epoch."""
        return self.state.learner.parameters


def train(task: Task, config: TrainingConfig, resume: RunState | None = None) -> Iterator[Progress]:
    """Train a policy; yields after every epoch.

    Args:
        task: the grounded task.
        config: hyper-parameters and budget.
        resume: state of an earlier run of the same task and configuration; what follows is what
            the uninterrupted run would have given.
    """
    algorithm = config.algorithm
    state = resume if resume is not None else fresh_state(task, config)
    problems = epoch_problems(task, algorithm, int(state.epoch) + 1)
    compiling = time.perf_counter()
    with ThreadPoolExecutor(1) as pool:
        evaluators_job = pool.submit(
            evaluation_programs, task, algorithm, algorithm.evaluation_states
        )
        programs = training_programs(task, algorithm)
        evaluators = evaluators_job.result()
    compile_seconds = time.perf_counter() - compiling
    began = time.perf_counter() - float(state.seconds)
    while not _done(state, config, began):
        epoch = int(state.epoch) + 1
        learner, batch = _epoch(task, problems(epoch), programs, algorithm, state.learner, epoch)
        evaluation = None
        if epoch % config.evaluate_every == 0 or epoch == config.epochs:
            key = jax.random.fold_in(jax.random.key(config.seed), 2**20 + epoch)
            evaluation = evaluate_layouts(task, evaluators, learner.parameters, key)
        jax.block_until_ready(learner)
        state = _after(state, learner, evaluation, config, epoch, time.perf_counter() - began)
        yield Progress(
            epoch,
            epoch * algorithm.environments * task.steps,
            float(state.seconds),
            compile_seconds,
            float(np.mean(np.asarray(batch.success))),
            float(np.mean(np.asarray(batch.reward))),
            int(batch.diverged),
            evaluation,
            state,
        )


def fresh_state(task: Task, config: TrainingConfig) -> RunState:
    """State before the first epoch."""
    learner = fresh_learner(task, config.algorithm, config.seed)
    return RunState(
        learner,
        learner.parameters,
        jnp.float32(-1),
        jnp.float32(-jnp.inf),
        jnp.int32(0),
        jnp.float32(0),
        jnp.bool_(False),
    )


def final_evaluation(task: Task, config: TrainingConfig, parameters: Parameters) -> Evaluation:
    """Evaluation on initial states that no evaluation during training has seen."""
    key = jax.random.fold_in(jax.random.key(config.seed), 2**21)
    return evaluate(task, evaluation_programs(task, config.algorithm), parameters, key)


def _done(state: RunState, config: TrainingConfig, began: float) -> bool:
    spent = time.perf_counter() - began
    return bool(state.finished) or int(state.epoch) >= config.epochs or spent >= config.time_limit


def _epoch(
    task: Task,
    problem: Problem,
    programs: TrainingPrograms,
    algorithm: Algorithm,
    learner: LearnerState,
    epoch: int,
) -> tuple[LearnerState, Batch]:
    in_model = epoch <= algorithm.model_epochs
    collect = programs.collect if in_model else programs.collect_in_physics
    batch = collect(problem, learner)
    if isinstance(algorithm.mode, PaperMode):
        batch = _with_terminal_robustness(task, batch, algorithm.mode.scale)
    return programs.update(learner, batch), batch


def _with_terminal_robustness(task: Task, batch: Batch, scale: float) -> Batch:
    """Add the formula's robustness to the last reward of each first episode (Sec. 4.2)."""
    positions = batch.position
    margins = _margins(task, positions)
    score = trace_robustness(task, margins)
    final = np.where(np.isfinite(score), score, 0.0)  # who broke down has been punished
    reward = jnp.asarray(batch.reward).at[task.horizon - 1].add(scale * jnp.float32(final))
    return batch._replace(reward=reward, robustness=jnp.asarray(score, jnp.float32))


def _margins(task: Task, positions: Array) -> np.ndarray:
    flat = positions.reshape(-1, positions.shape[-1])
    margins = _batch_margins(task.world)(task.problem.world, flat)
    return np.asarray(margins).reshape(*positions.shape[:2], -1)


@cache
def _batch_margins(world: World) -> Callable:
    """Margins [B, A] of positions [B, d]; compiled once for each number of positions."""
    return jax.jit(lambda data, flat: jax.vmap(lambda p: world.margins(data, p)[0])(flat))


def _after(
    state: RunState,
    learner: LearnerState,
    evaluation: Evaluation | None,
    config: TrainingConfig,
    epoch: int,
    seconds: float,
) -> RunState:
    state = state._replace(learner=learner, epoch=jnp.int32(epoch), seconds=jnp.float32(seconds))
    if evaluation is None:
        return state
    score = (evaluation.success_rate, evaluation.robustness_mean)
    if score < (float(state.best_success), float(state.best_robustness)):
        return state
    return state._replace(
        best=learner.parameters,
        best_success=jnp.float32(score[0]),
        best_robustness=jnp.float32(score[1]),
        finished=jnp.bool_(score[0] >= config.target),
    )
