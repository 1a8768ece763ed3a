"""The closed-loop controller of a trained policy as three pure functions, and their export.

    score(x0, t) -> V(s_0, t) - 10 * shortfall(t)    how promising schedule t is from state x0
    start(x0, t) -> s                                the controller's memory at step 0
    step(s, x)   -> (s', u)                          u in [-1, 1]^m for the measured state x

The memory s is the augmented state of Sec. 4.2 beside the schedule. The grounded MDP advances an
episode by simulating the robot; here the *measured* state takes the simulation's place, so the
same code serves both. The weights and the task are constants of the exported programs.

Dimensions: n state, m action, V variables of the formula (not padded), F distance fields.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax import export

from core.algorithm import Algorithm
from core.episode import Episode
from core.grounding import MAX_SUBGOALS, MAX_VARIABLES
from core.networks import Parameters
from core.physics import MeasuredRobot
from core.problem import Problem
from core.protocols import Array, Robot, World
from core.rollout import Grounded, Setting, View, advance, begin, score_schedules
from core.task import Task
from core.windows import windows_of

PLATFORMS = ("cpu", "cuda")
"""Where the exported programs run."""


class Controller(NamedTuple):
    """The three functions, traceable by JAX."""

    score: Callable[[Array, Array], Array]
    start: Callable[[Array, Array], tuple[Array, ...]]
    step: Callable[[tuple[Array, ...], Array], tuple[tuple[Array, ...], Array]]


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


def make_controller(task: Task, algorithm: Algorithm, parameters: Parameters) -> Controller:
    """Controller of a task; one call of `step` per step of the robot, from step 0 on."""
    problem = _compact(task.problem)
    robot = cast(Robot, MeasuredRobot(task.robot))
    setting = Setting(robot, _CompactWorld(task.world), algorithm, task.steps)

    def pad(schedule: Array) -> Array:
        return jnp.zeros(MAX_VARIABLES, jnp.int32).at[: schedule.shape[0]].set(schedule)

    def grounded(schedule: Array) -> Grounded:
        # The reserve of the legs is the critic's business, not the policy's.
        return Grounded(windows_of(problem, schedule), jnp.zeros(MAX_SUBGOALS), jnp.zeros(()))

    def score(x0: Array, t: Array) -> Array:
        value, short = score_schedules(setting, problem, parameters, x0[None], pad(t)[None])
        return algorithm.preference(value, short)[0]

    def start(x0: Array, t: Array) -> tuple[Array, ...]:
        def first() -> Episode:
            return begin(setting, problem, grounded(pad(t)), x0, jnp.float32(0)).episode

        blank = jax.tree.map(lambda leaf: jnp.zeros(leaf.shape, leaf.dtype), jax.eval_shape(first))
        return (pad(t), jnp.bool_(False), *blank._replace(state=x0))

    def step(s: tuple[Array, ...], x: Array) -> tuple[tuple[Array, ...], Array]:
        schedule, started, *memory = s
        windows = grounded(schedule)
        begun = begin(setting, problem, windows, x, jnp.float32(0))
        before = View(Episode(*memory), begun.sense, begun.policy, begun.critic)
        following, _, _ = advance(setting, problem, windows, before, x)
        view = jax.tree.map(lambda new, old: jnp.where(started, new, old), following, begun)
        action = jnp.clip(setting.networks.action(parameters, view.policy), -1.0, 1.0)
        return (schedule, jnp.bool_(True), *view.episode), action

    return Controller(score, start, step)


def export_controller(task: Task, algorithm: Algorithm, parameters: Parameters) -> dict[str, bytes]:
    """StableHLO programs `score`, `start` and `step`, serialized by `jax.export`.

    Matrix products are asked for in full precision, so that a GPU gives the CPU's actions.
    """
    controller = make_controller(task, algorithm, parameters)
    count = len(task.grounding.decomposition.variables)
    state = jax.ShapeDtypeStruct((task.robot.state_size,), jnp.float32)
    schedule = jax.ShapeDtypeStruct((count,), jnp.int32)
    memory = jax.eval_shape(controller.start, state, schedule)
    arguments = {"score": (state, schedule), "start": (state, schedule), "step": (memory, state)}
    with jax.default_matmul_precision("highest"):
        return {
            name: bytes(
                export.export(jax.jit(getattr(controller, name)), platforms=PLATFORMS)(
                    *shapes
                ).serialize(vjp_order=0)
            )
            for name, shapes in arguments.items()
        }


def _compact(problem: Problem) -> Problem:
    """The problem with every different distance field once; padding shares one empty field."""
    fields = np.asarray(problem.world.fields)
    first: dict[bytes, int] = {}
    rows = np.array([first.setdefault(field.tobytes(), len(first)) for field in fields], np.int32)
    kept = np.stack([fields[rows == row][0] for row in range(len(first))])
    world = problem.world._replace(fields=jnp.asarray(kept))
    return problem._replace(world=(world, jnp.asarray(rows)))
