"""Compiled programs: one set per robot, world, algorithm and size.

Compilation is explicit (ahead of time) and its duration is known; a program refuses arguments
of other shapes or types instead of compiling again behind the caller's back. With JAX's on-disk
cache switched on (`use_disk_cache`), a later process finds the compiled programs there.
"""

import os
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from core.algorithm import Algorithm
from core.grounding import MAX_VARIABLES
from core.learner import LearnerState, make_optimizer, update
from core.problem import Problem
from core.protocols import Array
from core.rollout import (
    Batch,
    Rollout,
    Setting,
    begin,
    choose_schedules,
    collect,
    feasible_schedules,
    ground_schedule,
    initial_states,
    roll_out,
    score_schedules,
)
from core.sampler import Elite
from core.task import Task

EVALUATION_STATES = 512
"""Initial states of an evaluation (Sec. 5.1)."""


class TrainingPrograms(NamedTuple):
    """Compiled programs of a training run."""

    start: Callable[[Problem, Array], LearnerState]
    collect: Callable[[Problem, LearnerState], Batch]
    update: Callable[[LearnerState, Batch], LearnerState]
    seconds: float


class EvaluationPrograms(NamedTuple):
    """Compiled programs for R rollouts at a time."""

    initial: Callable[[Problem, Array], Array]
    choose: Callable[[Problem, Any, Array, Array], tuple[Array, Array]]
    roll_out: Callable[[Problem, Any, Array, Array], Rollout]
    seconds: float


def use_disk_cache(folder: Path | None = None) -> Path:
    """Keep compiled programs on disk, by default in the user's cache directory."""
    if folder is None:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
        folder = Path(base) / "tgpo-studio" / "jax"
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.1)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return folder


def setting_of(task: Task, algorithm: Algorithm) -> Setting:
    """What the programs of a task are compiled for."""
    return Setting(task.robot, task.world, algorithm, task.steps)


def training_programs(task: Task, algorithm: Algorithm) -> TrainingPrograms:
    """Programs that train on the task; compiled at the first call for its size."""
    return _training_programs(setting_of(task, algorithm), _Shapes(task.problem))


def evaluation_programs(
    task: Task, algorithm: Algorithm, rollouts: int = EVALUATION_STATES
) -> EvaluationPrograms:
    """Programs that evaluate on the task; compiled at the first call for their size."""
    return _evaluation_programs(setting_of(task, algorithm), _Shapes(task.problem), rollouts)


def scoring_program(task: Task, algorithm: Algorithm, count: int) -> Callable:
    """Compiled V(s_0, t) of `count` schedules [N, V] from one state [n]; see the heatmap."""
    return _scoring_program(setting_of(task, algorithm), _Shapes(task.problem), count)


class _Shapes:
    """Shapes and types of a problem, hashable: the key of a compiled program."""

    def __init__(self, problem: Problem):
        leaves, structure = jax.tree.flatten(problem)
        self.key = (structure, tuple((leaf.shape, str(leaf.dtype)) for leaf in leaves))
        self.struct: Problem = jax.tree.map(
            lambda leaf: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype), problem
        )

    def __hash__(self) -> int:
        return hash(self.key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Shapes) and self.key == other.key


def _start(setting: Setting, problem: Problem, key: Array) -> LearnerState:
    """Fresh learner state."""
    algorithm = setting.algorithm
    network_key, state_key, chain_key, elite_key, next_key = jax.random.split(key, 5)
    states = initial_states(setting, problem, state_key, algorithm.elite_capacity)
    elite = feasible_schedules(setting, problem, elite_key, states)
    chains = feasible_schedules(setting, problem, chain_key, states)[: algorithm.count_mcmc]
    position = setting.robot.position(states[0])
    grounded = ground_schedule(setting, problem, position, elite[0])
    view = begin(setting, problem, grounded, states[0], jnp.float32(0))
    parameters = setting.networks.initial(
        network_key, view.policy.shape[0], view.critic.shape[0], algorithm.log_std
    )
    return LearnerState(
        parameters,
        make_optimizer(algorithm).init(parameters),
        next_key,
        chains,
        Elite(elite, jnp.full(algorithm.elite_capacity, -1e6)),
    )


def _collect(setting: Setting, problem: Problem, state: LearnerState) -> Batch:
    collect_key = jax.random.fold_in(state.key, 1)
    return collect(setting, problem, state.parameters, state.chains, state.elite, collect_key)


def _score(setting: Setting, problem: Problem, parameters, state, schedules):
    states = jnp.broadcast_to(state, (schedules.shape[0], *state.shape))
    return score_schedules(setting, problem, parameters, states, schedules)


@cache
def _training_programs(setting: Setting, shapes: _Shapes) -> TrainingPrograms:
    began = time.perf_counter()
    start = partial(_start, setting)
    collector = partial(_collect, setting)
    key = jax.eval_shape(lambda: jax.random.key(0))
    state = jax.eval_shape(start, shapes.struct, key)
    batch = jax.eval_shape(collector, shapes.struct, state)
    compiled = _compile(
        (collector, (shapes.struct, state)),
        (partial(update, setting), (state, batch)),
        (start, (shapes.struct, key)),
    )
    return TrainingPrograms(
        compiled[2], compiled[0], compiled[1], time.perf_counter() - began
    )


@cache
def _evaluation_programs(setting: Setting, shapes: _Shapes, rollouts: int) -> EvaluationPrograms:
    began = time.perf_counter()
    initial = partial(_initial, setting, rollouts)
    key = jax.eval_shape(lambda: jax.random.key(0))
    parameters = jax.eval_shape(partial(_start, setting), shapes.struct, key).parameters
    states = jax.eval_shape(initial, shapes.struct, key)
    schedules = jax.ShapeDtypeStruct((rollouts, MAX_VARIABLES), jnp.int32)
    compiled = _compile(
        (partial(roll_out, setting), (shapes.struct, parameters, states, schedules)),
        (partial(choose_schedules, setting), (shapes.struct, parameters, key, states)),
        (initial, (shapes.struct, key)),
    )
    return EvaluationPrograms(
        compiled[2], compiled[1], compiled[0], time.perf_counter() - began
    )


@cache
def _scoring_program(setting: Setting, shapes: _Shapes, count: int) -> Callable:
    key = jax.eval_shape(lambda: jax.random.key(0))
    parameters = jax.eval_shape(partial(_start, setting), shapes.struct, key).parameters
    state = jax.ShapeDtypeStruct((setting.robot.state_size,), jnp.float32)
    schedules = jax.ShapeDtypeStruct((count, MAX_VARIABLES), jnp.int32)
    return _compile((partial(_score, setting), (shapes.struct, parameters, state, schedules)))[0]


def _initial(setting: Setting, count: int, problem: Problem, key: Array) -> Array:
    return initial_states(setting, problem, key, count)


def _compile(*functions: tuple[Callable, tuple]) -> list[Any]:
    """Compile functions for their arguments' shapes, two at a time."""
    with ThreadPoolExecutor(2) as pool:
        jobs = [
            pool.submit(lambda f=f, a=a: jax.jit(f).lower(*a).compile()) for f, a in functions
        ]
        return [job.result() for job in jobs]
