"""A trained policy as four programs that need nothing but JAX.

    score(x0, t) -> value    how promising schedule t is from state x0
    start(x0, t) -> s        the controller's memory at step 0
    step(s, x)   -> (s', u)  u in [-1, 1]^m for the measured state x
    rescore(xs, k, t) -> value   how promising schedule t is at step k of the trace xs [T + 1, n]

The first three are those of `core.controller`; weights and task are constants of the programs, and
the memory s is a tuple of arrays.

Dimensions: n state, m action, V variables of the formula (not padded), F distance fields.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jax import export

from core.controller import Controller, pad_schedule
from core.task.later import failures, later, past_margins
from core.task.problem import Problem
from core.task.protocols import Array, World
from core.task.task import Task

PLATFORMS = ("cpu", "cuda")
"""Where the exported programs run."""

FAILED = 1e4
"""What `rescore` takes off for each task of a schedule that the past has made fail; more than any
difference between values."""

_LOCATIONS = "jax_traceback_in_locations_limit"


class Functions(NamedTuple):
    """The functions of a controller for one task, traceable by JAX."""

    score: Callable[[Array, Array], Array]
    start: Callable[[Array, Array], tuple[Array, ...]]
    step: Callable[[tuple[Array, ...], Array], tuple[tuple[Array, ...], Array]]
    rescore: Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class _CompactWorld:
    """A world whose equal distance fields are kept once; its data is (data, rows [F])."""

    world: World

    def margins(self, data: Any, position: Array) -> tuple[Array, Array]:
        return self.world.margins(data[0], position)

    def field(self, data: Any, index: Array, position: Array) -> tuple[Array, Array]:
        return self.world.field(data[0], data[1][index], position)

    def sample_initial(self, data: Any, key: Array) -> Array:
        return self.world.sample_initial(data[0], key)


def functions_of(task: Task, controller: Controller) -> Functions:
    """A controller of a task; one call of `step` per step of the robot, from step 0 on."""
    problem = _compact(task.problem)
    state = jax.ShapeDtypeStruct((task.robot.state_size,), jnp.float32)
    schedule = jax.ShapeDtypeStruct(task.problem.formula.low.shape, jnp.int32)
    memory = jax.eval_shape(lambda x0, t: controller.start(problem, x0, t), state, schedule)
    structure = jax.tree.structure(memory)

    def score(x0: Array, t: Array) -> Array:
        return controller.score(problem, x0, pad_schedule(problem, t))

    def start(x0: Array, t: Array) -> tuple[Array, ...]:
        return tuple(jax.tree.leaves(controller.start(problem, x0, pad_schedule(problem, t))))

    def step(s: tuple[Array, ...], x: Array) -> tuple[tuple[Array, ...], Array]:
        after, action = controller.step(problem, jax.tree.unflatten(structure, s), x)
        return tuple(jax.tree.leaves(after)), action

    def rescore(xs: Array, k: Array, t: Array) -> Array:
        chosen = pad_schedule(problem, t)
        failed = failures(problem, past_margins(problem, xs), k, chosen)
        return controller.score(later(problem, k), xs[k], chosen) - FAILED * failed

    return Functions(score, start, step, rescore)


def export_controller(task: Task, controller: Controller) -> dict[str, bytes]:
    """StableHLO programs of the functions, by name, serialized by `jax.export`.

    Matrix products use full precision, so that a GPU gives the same actions as a CPU. Equal
    weights give equal bytes: where in the source an operation was written is left out.
    """
    functions = functions_of(task, controller)
    count = len(task.grounding.decomposition.variables)
    state = jax.ShapeDtypeStruct((task.robot.state_size,), jnp.float32)
    schedule = jax.ShapeDtypeStruct((count,), jnp.int32)
    memory = jax.eval_shape(functions.start, state, schedule)
    trace = jax.ShapeDtypeStruct((task.horizon + 1, task.robot.state_size), jnp.float32)
    arguments = {
        "score": (state, schedule),
        "start": (state, schedule),
        "step": (memory, state),
        "rescore": (trace, jax.ShapeDtypeStruct((), jnp.int32), schedule),
    }
    with _without_source_locations(), jax.default_matmul_precision("highest"):
        return {
            name: bytes(
                export.export(jax.jit(getattr(functions, name)), platforms=PLATFORMS)(
                    *shapes
                ).serialize(vjp_order=0)
            )
            for name, shapes in arguments.items()
        }


@contextmanager
def _without_source_locations() -> Iterator[None]:
    """Leave files and lines out of what is lowered: they tell of the caller and its machine."""
    before = jax.config.values[_LOCATIONS]
    jax.config.update(_LOCATIONS, 0)
    try:
        yield
    finally:
        jax.config.update(_LOCATIONS, before)


def _compact(problem: Problem) -> Problem:
    """The problem with every different distance field once; padding shares one empty field.

    Where regions move, a table says which field counts when; it takes the place of that index.
    """
    fields = np.asarray(problem.data.fields)
    first: dict[bytes, int] = {}
    rows = np.array([first.setdefault(field.tobytes(), len(first)) for field in fields], np.int32)
    kept = np.stack([fields[rows == row][0] for row in range(len(first))])
    data = problem.data._replace(fields=jnp.asarray(kept))
    if data.paths is not None:
        paths = data.paths._replace(row=jnp.asarray(rows)[data.paths.row])
        return replace(problem, data=data._replace(paths=paths))
    return replace(problem, world=_CompactWorld(problem.world), data=(data, jnp.asarray(rows)))
