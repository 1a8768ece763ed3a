"""Compiled programs: one set per robot, world, algorithm and size.

Compilation is explicit (ahead of time) and its duration is known; a program refuses arguments
of other shapes or types instead of compiling again behind the caller's back. With JAX's on-disk
cache switched on (`use_disk_cache`), a later process finds the compiled programs there.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np

from core.algorithm import Algorithm
from core.collection import (
    Batch,
    collect,
    collect_layouts,
    explore,
    finish,
    prepare,
    settle,
)
from core.grounding import MAX_VARIABLES
from core.learner import LearnerState, make_optimizer, update
from core.physics import MeasuredRobot, Physics, physics_of
from core.problem import Problem
from core.protocols import Array, Robot
from core.rollout import (
    Rollout,
    Setting,
    begin,
    choose_schedules,
    depart,
    ground_schedule,
    initial_states,
    proceed,
    roll_out,
    score_schedules,
    trace_margins,
)
from core.sampler import Elite
from core.simulation import (
    CollectionPieces,
    RolloutPieces,
    collect_in_physics,
    roll_out_in_physics,
)
from core.task import Task
from core.windows import shortest_leg, windows_of

EVALUATION_STATES = 512
"""Initial states of an evaluation (Sec. 5.1)."""


class TrainingPrograms(NamedTuple):
    """Compiled programs of a training run."""

    collect: Callable[[Problem, LearnerState], Batch]
    """By the robot's `step`."""
    collect_in_physics: Callable[[Problem, LearnerState], Batch]
    """By the robot's truth: the same program where `step` is the truth."""
    update: Callable[[LearnerState, Batch], LearnerState]


class EvaluationPrograms(NamedTuple):
    """Compiled programs for R rollouts at a time."""

    initial: Callable[[Problem, Array], Array]
    choose: Callable[[Problem, Any, Array, Array], tuple[Array, Array]]
    roll_out: Callable[[Problem, Any, Array, Array], Rollout]
    """In the robot's true physics."""


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
    """Compiled V(s_0, t), shortfall and shortest leg of `count` schedules [N, V] from one state.

    See the heatmap.
    """
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


def fresh_learner(task: Task, algorithm: Algorithm, seed: int) -> LearnerState:
    """State of the learner before the first epoch: made on the host, nothing is compiled."""
    setting = setting_of(task, algorithm)
    policy_size, critic_size = _feature_sizes(setting, _Shapes(task.problem))
    parameters = setting.networks.initial(seed, policy_size, critic_size, algorithm.log_std)
    low, high = np.asarray(task.problem.formula.low), np.asarray(task.problem.formula.high)
    random = np.random.default_rng([seed, 1])

    def schedules(count: int) -> Array:
        drawn = random.integers(low, high + 1, (count, low.size))
        return jnp.asarray(drawn, jnp.int32)

    return LearnerState(
        parameters,
        make_optimizer(algorithm).init(parameters),
        jax.random.key(seed),
        schedules(algorithm.count_mcmc),
        Elite(
            schedules(algorithm.elite_capacity),
            jnp.full(algorithm.elite_capacity, -1e6, jnp.float32),
        ),
    )


def _collect(setting: Setting, problem: Problem, state: LearnerState) -> Batch:
    gather = collect if setting.algorithm.layouts == 1 else collect_layouts
    return gather(setting, problem, *_collected_with(state))


def _collected_with(state: LearnerState) -> tuple[Any, ...]:
    """What a batch depends on: parameters, chains, elite and its key."""
    collect_key = jax.random.fold_in(state.key, 1)
    return state.parameters, state.chains, state.elite, collect_key


def _score(setting: Setting, problem: Problem, parameters, state, schedules):
    states = jnp.broadcast_to(state, (schedules.shape[0], *state.shape))
    position, reserve = setting.robot.position(state), setting.algorithm.reserve

    def leg(schedule):
        windows = windows_of(problem, schedule)
        return shortest_leg(setting.robot, setting.world, problem, windows, position, reserve)

    values, shortfall = score_schedules(setting, problem, parameters, states, schedules)
    return values, shortfall, jax.vmap(leg)(schedules)


@cache
def _feature_sizes(setting: Setting, shapes: _Shapes) -> tuple[int, int]:
    """Numbers of features of the policy and the critic."""

    def first_view(problem, state, schedule):
        position = setting.robot.position(state)
        grounded = ground_schedule(setting, problem, position, schedule)
        return begin(setting, problem, grounded, state, jnp.float32(0))

    view = jax.eval_shape(first_view, shapes.struct, *_state_and_schedule(setting))
    return view.policy.shape[0], view.critic.shape[0]


def _state_and_schedule(setting: Setting, *batch: int) -> tuple[Any, Any]:
    """Shapes of states [*batch, n] and schedules [*batch, V]."""
    return (
        jax.ShapeDtypeStruct((*batch, setting.robot.state_size), jnp.float32),
        jax.ShapeDtypeStruct((*batch, MAX_VARIABLES), jnp.int32),
    )


@cache
def _learner_shapes(setting: Setting, shapes: _Shapes) -> LearnerState:
    """Shapes of the learner's state."""
    algorithm = setting.algorithm
    parameters = setting.networks.initial(0, *_feature_sizes(setting, shapes), 0.0)
    optimizer = make_optimizer(algorithm)
    _, elite = _state_and_schedule(setting, algorithm.elite_capacity)
    _, chains = _state_and_schedule(setting, algorithm.count_mcmc)
    scores: Any = jax.ShapeDtypeStruct((algorithm.elite_capacity,), jnp.float32)
    example: Any = (parameters, optimizer.init(parameters), jax.random.key(0))
    parameters, optimizer_state, key = jax.eval_shape(lambda: example)
    return LearnerState(parameters, optimizer_state, key, chains, Elite(elite, scores))


@cache
def _training_programs(setting: Setting, shapes: _Shapes) -> TrainingPrograms:
    state = _learner_shapes(setting, shapes)
    physics = physics_of(setting.robot)
    with ThreadPoolExecutor(1) as pool:
        problem = _stacked(shapes.struct, setting.algorithm.layouts)
        traced = jax.jit(partial(_collect, setting)).trace(problem, state)
        collector = pool.submit(_compile, traced)
        learner = jax.jit(partial(update, setting)).lower(state, traced.out_info).compile()
        model = truth = collector.result()
    if physics is not None and setting.algorithm.layouts == 1:
        truth = _physical_collection(physics, _measured(setting), shapes, state)
    return TrainingPrograms(model, truth, learner)


def _physical_collection(
    physics: Physics, setting: Setting, shapes: _Shapes, state: LearnerState
) -> Callable[[Problem, LearnerState], Batch]:
    def begin_batch(problem: Problem, state: LearnerState):
        return prepare(setting, problem, *_collected_with(state))

    def act(parameters, plan, stage, t):
        return explore(setting, parameters, stage, plan.noise[t])

    def proceed_batch(problem, plan, stage, measured, t):
        return settle(setting, problem, plan, stage, measured, plan.slots[t])

    environments = setting.algorithm.environments
    measured, _ = _state_and_schedule(setting, environments)
    t = jax.ShapeDtypeStruct((), jnp.int32)
    prepared = jax.jit(begin_batch).trace(shapes.struct, state)
    plan, stage = prepared.out_info
    settled = jax.jit(proceed_batch).trace(shapes.struct, plan, stage, measured, t)
    transitions = jax.tree.map(
        lambda leaf: jax.ShapeDtypeStruct((setting.steps, *leaf.shape), leaf.dtype),
        settled.out_info[1],
    )
    acting = jax.jit(act).trace(state.parameters, plan, stage, t)
    finished = jax.jit(finish).trace(plan, stage, transitions)
    pieces = CollectionPieces(*_compile_all(prepared, acting, settled, finished))
    return partial(collect_in_physics, physics, pieces, setting.steps)


def _stacked(problem: Problem, layouts: int) -> Problem:
    """Shapes of the problems of several layouts, stacked; of one problem as it is."""
    if layouts == 1:
        return problem
    return jax.tree.map(
        lambda leaf: jax.ShapeDtypeStruct((layouts, *leaf.shape), leaf.dtype), problem
    )


@cache
def _evaluation_programs(setting: Setting, shapes: _Shapes, rollouts: int) -> EvaluationPrograms:
    parameters = _learner_shapes(setting, shapes).parameters
    states, schedules = _state_and_schedule(setting, rollouts)
    key = jax.eval_shape(lambda: jax.random.key(0))
    choose = jax.jit(partial(choose_schedules, setting))
    initial = jax.jit(partial(_initial, setting, rollouts))
    traced = (
        choose.trace(shapes.struct, parameters, key, states),
        initial.trace(shapes.struct, key),
    )
    rolled = (shapes.struct, parameters, states, schedules)
    physics = physics_of(setting.robot)
    if physics is None:
        traced += (jax.jit(partial(roll_out, setting)).trace(*rolled),)
        compiled_choose, compiled_initial, roll = _compile_all(*traced)
        return EvaluationPrograms(compiled_initial, compiled_choose, roll)
    traced += _physical_rollout(_measured(setting), *rolled)
    compiled_choose, compiled_initial, *pieces = _compile_all(*traced)
    roll = partial(roll_out_in_physics, physics, RolloutPieces(*pieces), setting.steps)
    return EvaluationPrograms(compiled_initial, compiled_choose, roll)


def _physical_rollout(setting: Setting, problem, parameters, states, schedules) -> tuple[Any, ...]:
    """Traced `RolloutPieces`."""
    trace, _ = _state_and_schedule(setting, setting.steps + 1, states.shape[0])
    departed = jax.jit(partial(depart, setting)).trace(problem, parameters, states, schedules)
    course = departed.out_info
    proceeding = jax.jit(partial(proceed, setting))
    margins = jax.jit(partial(trace_margins, setting))
    return (
        departed,
        proceeding.trace(problem, parameters, course, states),
        margins.trace(problem, trace),
    )


def _measured(setting: Setting) -> Setting:
    """The setting in which the measured state is handed in, in the action's place."""
    return setting._replace(robot=cast(Robot, MeasuredRobot(setting.robot)))


@cache
def _scoring_program(setting: Setting, shapes: _Shapes, count: int) -> Callable:
    parameters = _learner_shapes(setting, shapes).parameters
    (state, _), (_, schedules) = _state_and_schedule(setting), _state_and_schedule(setting, count)
    score = jax.jit(partial(_score, setting))
    return _compile(score.trace(shapes.struct, parameters, state, schedules))


def _compile_all(*traced: Any) -> list[Any]:
    """Compile traced functions side by side."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(_compile, traced))


def _compile(traced: Any) -> Any:
    """Compile a traced function that is long and seldom called.

    The CPU backend's fusion emitters make such programs no faster here and cost a third of
    their compilation; the update, where they gain 10 %, is compiled with them.
    """
    return traced.lower().compile(compiler_options={"xla_cpu_use_fusion_emitters": False})


def _initial(setting: Setting, count: int, problem: Problem, key: Array) -> Array:
    return initial_states(setting, problem, key, count)
