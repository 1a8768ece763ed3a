"""Layouts of a task: perturbed scenes that can be solved, grounded.

A layout is good where the robot can be placed in every goal, and where at least a third as
many schedules as in the task's own layout leave time to travel. Others are drawn anew.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property

import jax
import jax.numpy as jnp
import numpy as np

from core.algorithm import Algorithm
from core.errors import UserError
from core.problem import Problem
from core.programs import setting_of
from core.protocols import Array
from core.rollout import Setting, ground_schedule, initial_states
from core.sampler import uniform_schedules
from core.stl import atom_names
from core.task import Layouts, Task
from scenes import Scene
from scenes.layouts import perturbed
from studio.tasks import WORLDS, build_task

STATES, SCHEDULES = 4, 4096
"""Initial states, and schedules of each, by which a layout is judged."""

LEAST_SHARE = 1 / 3
"""Schedules that leave time to travel, over those of the task's own layout."""

MOST_MISSED = 0.02
"""Largest share of places in goals that the robot may fail to reach."""

HELD_OUT, VALIDATION = 2**32 - 1, 2**32 - 2
"""Streams of layouts beside those of the training's seeds: to report on, to stop by."""

VALIDATIONS = 7
"""Layouts that a training is evaluated on beside the task's own."""

TRIES = 100
"""Layouts that are drawn for a good one at most."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """Good layouts of a scene, by their number; the same stream and number give the same."""

    scene: Scene
    task: Task
    algorithm: Algorithm
    stream: int

    def __call__(self, number: int) -> Problem:
        """The problem of a layout."""
        return self.layout(number)[1].problem

    @cached_property
    def _judge(self) -> Callable[[Problem], tuple[Array, Array]]:
        setting = setting_of(self.task, replace(self.algorithm, layouts=1, fresh_layouts=0))
        return _judgement(setting, WORLDS[self.scene.robot].clearance)

    @cached_property
    def _usual(self) -> float:
        return float(self._judge(self.task.problem)[0])

    def layout(self, number: int) -> tuple[Scene, Task]:
        """A layout.

        Raises:
            UserError: no layout of the scene can be solved.
        """
        goals = {
            name
            for subgoal in self.task.grounding.subgoals
            for name in atom_names(subgoal.predicate)
        }
        random = np.random.default_rng([self.stream, number])
        world = WORLDS[self.scene.robot]
        for _ in range(TRIES):
            scene = perturbed(self.scene, goals, world, random)
            try:
                task = build_task(scene)
            except UserError:  # a goal that left the workspace
                continue
            feasible, missed = self._judge(task.problem)
            if feasible >= LEAST_SHARE * self._usual and missed <= MOST_MISSED:
                return scene, task
        raise UserError(
            f"{self.scene.name}: of {TRIES} perturbed layouts none leaves time for the task. "
            "Allowed: regions with room around them, windows with time to spare"
        )


def randomized(scene: Scene, task: Task, algorithm: Algorithm, seed: int) -> Task:
    """The task with the layouts that an algorithm of several layouts learns on."""
    if algorithm.layouts == 1:
        return task
    validation = Drawing(scene, task, algorithm, VALIDATION)
    held_out = tuple(validation(number) for number in range(VALIDATIONS))
    return replace(task, layouts=Layouts(Drawing(scene, task, algorithm, seed), held_out))


def held_out(scene: Scene, task: Task, algorithm: Algorithm, count: int) -> Iterator[Task]:
    """Tasks in layouts that no training learns on: the same ones for every policy."""
    drawing = Drawing(scene, task, algorithm, HELD_OUT)
    for number in range(count):
        yield drawing.layout(number)[1]


@cache
def _judgement(setting: Setting, tolerance: float) -> Callable[[Problem], tuple[Array, Array]]:
    """Shares of schedules that leave time to travel, and of places in goals out of reach."""

    def judge(problem: Problem):
        draw_key, state_key, place_key = jax.random.split(jax.random.key(0), 3)
        states = initial_states(setting, problem, state_key, STATES)
        starts = jnp.repeat(jax.vmap(setting.robot.position)(states), SCHEDULES, axis=0)
        schedules = uniform_schedules(problem.formula, draw_key, len(starts))
        ground = jax.vmap(ground_schedule, (None, None, 0, 0))
        short = ground(setting, problem, starts, schedules).shortfall
        inside = problem.inside[:, ::4].reshape(-1, starts.shape[-1])
        placed = jax.vmap(setting.robot.place)(jax.random.split(place_key, len(inside)), inside)
        away = jnp.linalg.norm(jax.vmap(setting.robot.position)(placed) - inside, axis=-1)
        used = jnp.repeat(problem.formula.subgoals.mask, len(inside) // len(problem.inside))
        return (short <= 0).mean(), (used * (away > tolerance)).sum() / used.sum()

    return jax.jit(judge)
