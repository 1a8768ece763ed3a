"""Batches in true physics: compiled pieces of `collection`, the host's simulator between them."""

from collections.abc import Callable
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import program, shape_of
from core.methods.networks import Parameters
from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.collection import (
    Batch,
    Front,
    Plan,
    Sources,
    Transition,
    explore,
    finish,
    prepare,
    settle,
)
from core.task.physics import Physics
from core.task.problem import Problem
from core.task.protocols import Array


def collect_measured(
    physics: Physics,
    problem: Problem,
    sources: Sources,
    key: Array,
    *,
    algorithm: Algorithm,
    steps: int,
) -> Batch:
    """A batch of L steps in N environments, as `collect` does."""
    plan, front = _prepare(problem, sources, key, algorithm=algorithm, steps=steps)
    transitions = []
    for step in range(steps):
        t: Any = np.int32(step)
        action = _explore(problem, sources.parameters, plan, front, t, algorithm=algorithm)
        states = physics.step(np.asarray(front.view.episode.state), np.asarray(action))
        measured: Any = np.asarray(states, np.float32)
        front, transition = _settle(problem, plan, front, measured, t, algorithm=algorithm)
        transitions.append(jax.tree.map(np.asarray, transition))
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves), *transitions)
    return _finish(plan, front, stacked)


def measured_jobs(
    physics: Physics,
    problem: Problem,
    sources: Sources,
    key: Array,
    *,
    algorithm: Algorithm,
    steps: int,
) -> list[Callable[[], Any]]:
    """Compilations that `collect_measured` needs."""
    static = {"algorithm": algorithm}
    plan, front = _prepare.shapes(problem, sources, key, steps=steps, **static)
    states, t = plan.states, shape_of(dtype=jnp.int32)
    _, transition = _settle.shapes(problem, plan, front, states, t, **static)
    transitions = jax.tree.map(
        lambda leaf: shape_of(steps, *leaf.shape, dtype=leaf.dtype), transition
    )
    acting = partial(_explore.compile, problem, sources.parameters, plan, front, t, **static)
    return [
        partial(physics.warm_up, algorithm.environments),
        partial(_prepare.compile, problem, sources, key, steps=steps, **static),
        acting,
        partial(_settle.compile, problem, plan, front, states, t, **static),
        partial(_finish.compile, plan, front, transitions),
    ]


_prepare = program(prepare)
_finish = program(finish)


@program
def _explore(
    problem: Problem,
    parameters: Parameters,
    plan: Plan,
    front: Front,
    t: Array,
    *,
    algorithm: Algorithm,
) -> Array:
    return explore(problem, parameters, front, plan.noise[t], algorithm=algorithm)


@program
def _settle(
    problem: Problem,
    plan: Plan,
    front: Front,
    states: Array,
    t: Array,
    *,
    algorithm: Algorithm,
) -> tuple[Front, Transition]:
    return settle(problem, plan, front, states, plan.slots[t], algorithm=algorithm)
