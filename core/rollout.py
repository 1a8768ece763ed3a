"""Rollouts of controllers, and their choice of schedules.

Dimensions: R rollouts, L steps, V variables, n state, m action, A atoms.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.candidates import candidate_jobs, choose_schedules
from core.compilation import key_shape, program, shape_of
from core.controller import Controller
from core.task.physics import physics_of
from core.task.problem import Problem, initial_states, trace_margins
from core.task.protocols import Array
from core.task.task import Task


class Rollout(NamedTuple):
    """Deterministic rollouts."""

    states: Array  # [L + 1, R, n]
    actions: Array  # [L, R, m] in [-1, 1]
    margins: Array  # [L + 1, R, A] margins of the atoms [m]


start_states = program(initial_states)
"""`start_states(problem, key, count=R)`: compiled `initial_states`."""


def roll_out(
    task: Task,
    controller: Controller,
    states: Array,
    schedules: Array,
    nudges: np.ndarray | None = None,
) -> Rollout:
    """Carry out schedules [R, V] from states [R, n], in the robot's true physics.

    Args:
        task: the grounded task.
        controller: carries out the schedules.
        states: [R, n].
        schedules: [R, V].
        nudges: added to its actions [L, R, m]; nothing if None.
    """
    physics, problem = physics_of(task.robot), task.problem
    added = no_nudges(task, len(states)) if nudges is None else nudges
    if physics is None:
        return _roll_out(problem, controller, states, schedules, jnp.asarray(added))
    return _simulated(
        task,
        controller,
        states,
        schedules,
        added,
        lambda _, state, action: physics.step(state, action),
    )


def no_nudges(task: Task, count: int) -> np.ndarray:
    """Zeros [L, R, m] for R = count rollouts."""
    return np.zeros((task.padded_horizon, count, task.robot.action_size), np.float32)


def roll_out_choice(
    task: Task, controller: Controller, key: Array, *, count: int
) -> tuple[Array, Array, Rollout]:
    """Roll out the controller's choice once from each of R = count random initial states.

    Returns the schedules [R, V], their scores [R] and the rollouts.
    """
    initial_key, choice_key = jax.random.split(key)
    states = start_states(task.problem, initial_key, count=count)
    schedules, scores = choose_schedules(task.problem, controller, choice_key, states)
    return schedules, scores, roll_out(task, controller, states, schedules)


def roll_on(
    task: Task,
    controller: Controller,
    past: np.ndarray,
    known: np.ndarray,
    schedules: np.ndarray,
    nudges: np.ndarray | None = None,
) -> Rollout:
    """Carry on from the middle of episodes.

    The controller is led along the past, whatever has moved the robot there: its memory at the
    last known step is that of schedule and trace. From then on it acts.

    Args:
        task: the grounded task.
        controller: carries out the schedules.
        past: states [L + 1, R, n], of which steps 0 to `known` count.
        known: last known step of each rollout [R].
        schedules: [R, V].
        nudges: added to its actions [L, R, m]; nothing if None.
    """
    physics, problem = physics_of(task.robot), task.problem
    given, chosen = jnp.asarray(past, jnp.float32), jnp.asarray(schedules)
    added = no_nudges(task, len(schedules)) if nudges is None else nudges
    if physics is None:
        steps = jnp.asarray(known, jnp.int32)
        return _roll_on(problem, controller, given, steps, chosen, jnp.asarray(added))

    def after(step: int, state: np.ndarray, action: np.ndarray) -> np.ndarray:
        free = known <= step
        if not free.any():
            return past[step + 1]
        return np.where(free[:, None], physics.step(state, action), past[step + 1])

    return _simulated(task, controller, given[0], chosen, added, after)


def _simulated(
    task: Task,
    controller: Controller,
    states: Array,
    schedules: Array,
    nudges: np.ndarray,
    after: Callable[[int, np.ndarray, np.ndarray], Any],
) -> Rollout:
    """Rollouts in true physics; `after` gives the states [R, n] that follow a step."""
    memory = _start(task.problem, controller, states, schedules)
    visited, actions = [np.asarray(states)], []
    for step in range(task.padded_horizon):
        memory, action = _step(task.problem, controller, memory, visited[-1])
        actions.append(np.asarray(action) + nudges[step])
        visited.append(np.asarray(after(step, visited[-1], actions[-1]), np.float32))
    trace = jnp.asarray(np.stack(visited))
    return Rollout(trace, jnp.asarray(np.stack(actions)), _margins(task.problem, trace))


def roll_on_jobs(task: Task, controller: Controller, count: int) -> list[Callable[[], Any]]:
    """Compilations that R rollouts from the middle need, beyond those of rollouts."""
    if physics_of(task.robot) is not None:
        return []
    past = shape_of(task.padded_horizon + 1, count, task.robot.state_size, dtype=jnp.float32)
    schedules = shape_of(count, *task.problem.formula.low.shape, dtype=jnp.int32)
    known = shape_of(count, dtype=jnp.int32)
    nudges = _nudges_shape(task, count)
    return [partial(_roll_on.compile, task.problem, controller, past, known, schedules, nudges)]


def rollout_jobs(task: Task, controller: Controller, count: int) -> list[Callable[[], Any]]:
    """Compilations that R rollouts of chosen schedules need."""
    problem, steps, size = task.problem, task.padded_horizon, task.robot.state_size
    states: Any = shape_of(count, size, dtype=jnp.float32)
    schedules = shape_of(count, *problem.formula.low.shape, dtype=jnp.int32)
    jobs: list[Callable[[], Any]] = [
        partial(start_states.compile, problem, key_shape(), count=count),
        *candidate_jobs(task, controller),
    ]
    physics = physics_of(task.robot)
    if physics is None:
        nudges = _nudges_shape(task, count)
        return [*jobs, partial(_roll_out.compile, problem, controller, states, schedules, nudges)]
    memory = _start.shapes(problem, controller, states, schedules)
    return [
        *jobs,
        partial(physics.warm_up, count),
        partial(_start.compile, problem, controller, states, schedules),
        partial(_step.compile, problem, controller, memory, states),
        partial(_margins.compile, problem, shape_of(steps + 1, count, size, dtype=jnp.float32)),
    ]


def _nudges_shape(task: Task, count: int) -> Any:
    return shape_of(task.padded_horizon, count, task.robot.action_size, dtype=jnp.float32)


@program
def _start(problem: Problem, controller: Controller, states: Array, schedules: Array) -> Any:
    return jax.vmap(partial(controller.start, problem))(states, schedules)


@program
def _step(problem: Problem, controller: Controller, memory: Any, states: Any) -> tuple[Any, Array]:
    return jax.vmap(partial(controller.step, problem))(memory, states)


_margins = program(trace_margins)


@program
def _roll_out(
    problem: Problem, controller: Controller, states: Array, schedules: Array, nudges: Array
) -> Rollout:
    """Rollouts by the robot's own `step`."""
    return _rolled(problem, controller, states, schedules, nudges, None, lambda after, _: after)


@program
def _roll_on(
    problem: Problem,
    controller: Controller,
    past: Array,
    known: Array,
    schedules: Array,
    nudges: Array,
) -> Rollout:
    """Rollouts by the robot's own `step` after steps [R] of the past [L + 1, R, n]."""
    numbered = jnp.arange(1, past.shape[0]), past[1:]
    settle = partial(_settle, known)
    return _rolled(problem, controller, past[0], schedules, nudges, numbered, settle)


def carried(problem: Problem, past: Array, known: Array, actions: Array) -> tuple[Array, Array]:
    """States [L + 1, R, n] and margins of actions [L, R, m] by the robot's own `step`.

    Steps 0 to `known` [R] are those of the past [L + 1, R, n], whatever the actions.
    """

    def step(state: Array, now: tuple[Array, Any]) -> tuple[Array, Array]:
        action, given = now
        after = _settle(known, jax.vmap(problem.robot.step)(state, action), given)
        return after, after

    given = actions, (jnp.arange(1, past.shape[0]), past[1:])
    _, visited = jax.lax.scan(step, past[0], given)
    visited = jnp.concatenate([past[:1], visited])
    return visited, trace_margins(problem, visited)


def _settle(known: Array, after: Array, given: tuple[Array, Array]) -> Array:
    """The state after a step: that of the past, as long as it is known."""
    number, seen = given
    return jnp.where((number <= known)[:, None], seen, after)


def _rolled(
    problem: Problem,
    controller: Controller,
    states: Array,
    schedules: Array,
    nudges: Array,
    given: Any,
    settle: Callable[[Array, Any], Array],
) -> Rollout:
    """Rollouts; `settle` has the last word on the states [R, n] after each of the L `given`."""

    def step(carry: tuple[Any, Array], now: tuple[Array, Any]):
        memory, state = carry
        nudge, known = now
        memory, action = jax.vmap(partial(controller.step, problem))(memory, state)
        action = action + nudge
        after = settle(jax.vmap(problem.robot.step)(state, action), known)
        return (memory, after), (after, action)

    memory = jax.vmap(partial(controller.start, problem))(states, schedules)
    _, (visited, actions) = jax.lax.scan(step, (memory, states), (nudges, given))
    visited = jnp.concatenate([states[None], visited])
    return Rollout(visited, actions, trace_margins(problem, visited))
