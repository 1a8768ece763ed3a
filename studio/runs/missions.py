"""Missions that weights are trained and tested on: drawn, grounded and judged.

A mission is good if the robot can be placed in every goal, and if some schedules leave time to
travel: at least `LEAST_SHARE` of uniform ones. That share is its difficulty.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Protocol

import numpy as np

from core.errors import UserError
from core.methods.tgpo.algorithm import Algorithm
from core.task.problem import Problem
from core.task.task import Layouts, Task
from core.task.windows import RESERVE
from envs import make_robot
from scenes import Scene, load_task, make_world, task_names
from scenes.missions import SHIPPED_TRAINED, TRAINED, draw
from studio.runs.judge import Judgement, judge_of
from studio.runs.layouts import Drawing
from studio.runs.tasks import build_task

LEAST_SHARE = 0.003
"""Least share of uniform schedules that leave time to travel."""

TRIES = 100
"""Draws for one good mission."""

SHIPPED = "shipped"
"""What perturbed versions of shipped tasks are called where families are named."""

VALIDATION = 2**20
"""Stream of the missions that a training is evaluated on while it goes."""

VALIDATIONS = 12
RANDOM_SHARE = 0.6
"""Share of random missions in a training; the others are perturbed shipped tasks."""

EASY, KEPT, DRAWS = 0.3, 0.35, 4
"""Of missions with a larger share of good schedules this part is kept, in this many draws."""

STREAM_SIZE = 2**32
"""Missions of a stream; another stream draws others."""


@dataclass(frozen=True, eq=False)
class Mission:
    """A good mission.

    Attributes:
        scene: Its regions and formula.
        task: The scene grounded.
        family: One of `scenes.missions.FAMILIES`, or `SHIPPED`.
        seed: The number that it was asked for by.
        share: Of uniform schedules that leave time to travel.
    """

    scene: Scene
    task: Task
    family: str
    seed: int
    share: float


class Source(Protocol):
    """Missions by number: the same number gives the same mission, in every process."""

    def __call__(self, number: int) -> Mission:
        """The mission of a number.

        Raises:
            UserError: none comes about.
        """
        ...


def mission(robot_name: str, family: str, seed: int, *, shared: bool = False) -> Mission:
    """The first good draw of a family from a seed on.

    Args:
        robot_name: of the robot.
        family: one of `scenes.missions.FAMILIES`.
        seed: draws it.
        shared: whether it is grounded in arrays of the same shapes as others (`scenes.shared`).

    Raises:
        UserError: none of `TRIES` draws is good, or there is no such robot or family.
    """
    judge = _judge(robot_name)
    for attempt in range(TRIES):
        try:
            scene = draw(robot_name, family, seed * TRIES + attempt)
            task = build_task(scene, visits_extra=0, shared=shared)
        except UserError:  # no room, no time, or a goal inside an obstacle
            continue
        judgement = judge(task.problem)
        if judgement.share >= LEAST_SHARE and judgement.reachable:
            return Mission(scene, task, family, seed, judgement.share)
    raise UserError(
        f"{robot_name}: none of {TRIES} draws of the family {family!r} can be solved in time"
    )


@dataclass(frozen=True)
class RandomMissions:
    """Random missions of some families, each as often as the others.

    Attributes:
        robot: Name of the robot.
        stream: Missions of different streams are different.
        families: Names of the families.
        shared: Whether they are grounded in arrays of the same shapes.
    """

    robot: str
    stream: int
    families: Sequence[str] = TRAINED
    shared: bool = False

    def __call__(self, number: int) -> Mission:
        """The mission of a number."""
        family = self.families[number % len(self.families)]
        seed = self.stream * STREAM_SIZE + number
        return mission(self.robot, family, seed, shared=self.shared)


@dataclass(frozen=True, eq=False)
class ShippedMissions:
    """Perturbed layouts of shipped tasks, each as often as the others.

    Attributes:
        robot: Name of the robot.
        stream: Layouts of different streams are different.
        numbers: Which tasks.
        shared: Whether they are grounded in arrays of the same shapes.
    """

    robot: str
    stream: int
    numbers: Sequence[str] = SHIPPED_TRAINED
    shared: bool = False

    @cached_property
    def _drawings(self) -> list[Drawing]:
        scenes = [load_task(f"{self.robot}-{number}") for number in self.numbers]
        algorithm = Algorithm(reserve=RESERVE)
        return [
            Drawing(
                scene,
                build_task(scene, visits_extra=0, shared=self.shared),
                algorithm,
                self.stream,
                self.shared,
            )
            for scene in scenes
        ]

    def __call__(self, number: int) -> Mission:
        """The mission of a number."""
        drawings = self._drawings
        scene, task = drawings[number % len(drawings)].layout(number // len(drawings))
        share = _judge(self.robot)(task.problem).share
        return Mission(scene, task, SHIPPED, number, share)


@dataclass(frozen=True, eq=False)
class Demanding:
    """Missions of a source, fewer of the easy ones.

    Attributes:
        source: Where they come from.
        seed: Of the choice of easy ones that are kept.
    """

    source: Source
    seed: int = 0

    def __call__(self, number: int) -> Mission:
        """The mission of a number."""
        random = np.random.default_rng([self.seed, number])
        for draw_number in range(DRAWS):
            found = self.source(number * DRAWS + draw_number)
            if found.share <= EASY or random.random() < KEPT:
                break
        return found


@dataclass(frozen=True, eq=False)
class Mixture:
    """Missions of several sources, by their weights.

    Attributes:
        sources: Where missions come from.
        weights: Share of each; they sum to 1.
        seed: Of the choice among them.
    """

    sources: Sequence[Source]
    weights: Sequence[float]
    seed: int = 0

    def __call__(self, number: int) -> Mission:
        """The mission of a number."""
        random = np.random.default_rng([self.seed, number])
        return self.sources[random.choice(len(self.sources), p=self.weights)](number)


@cache
def _judge(robot_name: str) -> Callable[[Problem], Judgement]:
    workspace = make_robot(robot_name).workspace
    return judge_of(RESERVE, make_world(workspace).clearance)


def curriculum(robot_name: str, seed: int) -> Source:
    """What weights of a robot are trained on: random missions and perturbed shipped tasks.

    All are grounded in arrays of the same shapes.
    """
    missions = Demanding(RandomMissions(robot_name, seed, shared=True), seed)
    if f"{robot_name}-{SHIPPED_TRAINED[0]}" not in task_names(robot_name):
        return missions
    sources = (missions, ShippedMissions(robot_name, seed, shared=True))
    return Mixture(sources, (RANDOM_SHARE, 1 - RANDOM_SHARE), seed)


def with_missions(task: Task, robot_name: str, seed: int) -> Task:
    """The task, trained on the curriculum and evaluated on missions that it never draws.

    Args:
        task: of the robot, in arrays of shared shapes.
        robot_name: of the robot.
        seed: of the training.
    """
    source = curriculum(robot_name, seed)
    validation = RandomMissions(robot_name, VALIDATION, shared=True)

    def problem(number: int) -> Problem:
        return source(number).task.problem

    held_out = tuple(validation(number).task for number in range(1, 1 + VALIDATIONS))
    return replace(task, layouts=Layouts(problem, held_out))
