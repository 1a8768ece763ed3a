"""Rollouts and batches in true physics: compiled pieces, the host's simulator between them.

The pieces are those of `core.rollout` and `core.collection`, compiled for a `MeasuredRobot`.

Dimensions: R rollouts, L steps, N environments, n state, V variables.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.collection import Batch, Plan, Stage, Transition
from core.learner import LearnerState
from core.networks import Parameters
from core.physics import Physics
from core.problem import Problem
from core.protocols import Array
from core.rollout import Course, Rollout


class RolloutPieces(NamedTuple):
    """Compiled `depart`, `proceed` and `trace_margins`."""

    depart: Callable[[Problem, Parameters, Array, Array], Course]
    proceed: Callable[[Problem, Parameters, Course, Any], Course]
    margins: Callable[[Problem, Any], Array]


class CollectionPieces(NamedTuple):
    """Compiled `prepare`, `explore`, `settle` and `finish`; t is the step."""

    prepare: Callable[[Problem, LearnerState], tuple[Plan, Stage]]
    explore: Callable[[Parameters, Plan, Stage, Any], Array]
    settle: Callable[[Problem, Plan, Stage, Any, Any], tuple[Stage, Transition]]
    finish: Callable[[Plan, Stage, Any], Batch]


def roll_out_in_physics(
    physics: Physics,
    pieces: RolloutPieces,
    steps: int,
    problem: Problem,
    parameters: Parameters,
    states: Array,
    schedules: Array,
) -> Rollout:
    """Carry out schedules [R, V] from states [R, n] with the mean action, as `roll_out` does."""
    course = pieces.depart(problem, parameters, states, schedules)
    visited, actions = [np.asarray(states)], []
    for _ in range(steps):
        actions.append(np.asarray(course.action))
        visited.append(_measured(physics, visited[-1], actions[-1]))
        course = pieces.proceed(problem, parameters, course, visited[-1])
    trace = np.stack(visited)
    margins = pieces.margins(problem, trace)
    return Rollout(jnp.asarray(trace), jnp.asarray(np.stack(actions)), margins)


def collect_in_physics(
    physics: Physics,
    pieces: CollectionPieces,
    steps: int,
    problem: Problem,
    state: LearnerState,
) -> Batch:
    """A batch of L steps in N environments, as `collect` does."""
    plan, stage = pieces.prepare(problem, state)
    transitions = []
    for t in range(steps):
        action = pieces.explore(state.parameters, plan, stage, np.int32(t))
        measured = _measured(physics, np.asarray(stage.view.episode.state), np.asarray(action))
        stage, transition = pieces.settle(problem, plan, stage, measured, np.int32(t))
        transitions.append(jax.tree.map(np.asarray, transition))
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves), *transitions)
    return pieces.finish(plan, stage, stacked)


def _measured(physics: Physics, states: np.ndarray, actions: np.ndarray) -> np.ndarray:
    return np.asarray(physics.step(states, actions), np.float32)
