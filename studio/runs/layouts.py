"""Layouts of a task: perturbed scenes that can be solved, grounded.

A layout is good if the robot can be placed in every goal, and if at least a third as many
schedules as in the task's own layout leave time to travel. Other layouts are redrawn.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from core.errors import UserError
from core.methods.tgpo.algorithm import Algorithm
from core.quoting import listed
from core.stl import atom_names, quote_name
from core.task.problem import Problem
from core.task.task import Layouts, Task
from scenes import Scene, world_of
from scenes.layouts import perturbed
from studio.runs.judge import Judgement, judge_of
from studio.runs.tasks import build_task

LEAST_SHARE = 1 / 3
"""Schedules that leave time to travel, over those of the task's own layout."""

HELD_OUT, VALIDATION = 2**32 - 1, 2**32 - 2
"""Streams of layouts apart from those of the training seeds: for reporting, and for stopping."""

VALIDATIONS = 7
"""Layouts that a training is evaluated on besides the task's own."""

TRIES = 100
"""Maximum number of draws for one good layout."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """Good layouts of a scene, by their number; the same stream and number give the same.

    Attributes:
        scene: The original.
        task: The scene grounded.
        algorithm: Whose planned ways a layout must leave time for.
        stream: Layouts of different streams are different.
        shared: Whether layouts are grounded in arrays of shared shapes, as `task` is.
    """

    scene: Scene
    task: Task
    algorithm: Algorithm
    stream: int
    shared: bool = False

    def __call__(self, number: int) -> Problem:
        """The problem of a layout."""
        return self.layout(number)[1].problem

    @cached_property
    def _judge(self) -> Callable[[Problem], Judgement]:
        return judge_of(self.algorithm.reserve, world_of(self.scene).clearance)

    @cached_property
    def _usual(self) -> float:
        return self._judge(self.task.problem).share

    def layout(self, number: int) -> tuple[Scene, Task]:
        """A layout.

        Raises:
            UserError: regions move, or no layout of the scene can be solved.
        """
        if self.scene.moving:
            names = listed(sorted(map(quote_name, self.scene.moving)))
            raise UserError(
                f"{self.scene.name}: other layouts are drawn of regions that stand, but {names} "
                f"{'moves' if len(self.scene.moving) == 1 else 'move'}; train on this scene alone"
            )
        goals = {
            name
            for subgoal in self.task.grounding.subgoals
            for name in atom_names(subgoal.predicate)
        }
        random = np.random.default_rng([self.stream, number])
        world = world_of(self.scene)
        visits = self.task.grounding.decomposition.visits_extra
        for _ in range(TRIES):
            scene = perturbed(self.scene, goals, world, random)
            try:
                task = build_task(scene, visits_extra=visits, shared=self.shared)
            except UserError:  # a goal that left the workspace
                continue
            judgement = self._judge(task.problem)
            if judgement.share >= LEAST_SHARE * self._usual and judgement.reachable:
                return scene, task
        raise UserError(
            f"{self.scene.name}: none of {TRIES} perturbed layouts leaves time for the task; "
            "leave more room around the regions or more time in the formula"
        )


def randomized(scene: Scene, task: Task, algorithm: Algorithm, seed: int) -> Task:
    """The task with the layouts that an algorithm of several layouts learns on."""
    if algorithm.layouts == 1:
        return task
    validation = Drawing(scene, task, algorithm, VALIDATION)
    held_out = tuple(validation.layout(number)[1] for number in range(VALIDATIONS))
    return replace(task, layouts=Layouts(Drawing(scene, task, algorithm, seed), held_out))


def held_out(scene: Scene, task: Task, algorithm: Algorithm, count: int) -> Iterator[Task]:
    """Tasks in layouts that no training learns on: the same ones for every policy."""
    drawing = Drawing(scene, task, algorithm, HELD_OUT)
    for number in range(count):
        yield drawing.layout(number)[1]
