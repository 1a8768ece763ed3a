"""What weights reach on tasks that they were not trained on."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import jax
import msgspec
import numpy as np
from msgspec import Meta

from core.answer import answer
from core.controller import Controller
from core.documents import Share
from core.evaluation import evaluate
from core.rollout import start_states
from core.task.physics import physics_of
from core.task.task import Task
from scenes import load_task, task_names
from scenes.missions import HELD_OUT, SHIPPED_HELD_OUT
from studio.runs.missions import mission
from studio.runs.tasks import build_task

GOOD = 0.9
"""Success rate from which a task counts as solved."""

REPORTED = 2**21
"""First seed of the missions that are reported on; no training draws them."""


Count = Annotated[int, Meta(ge=0)]


class HeldOut(msgspec.Struct, kw_only=True, frozen=True):
    """Results on a set of tasks."""

    name: str
    tasks: Count
    chosen: Count
    """Tasks that the critic's one choice solves from at least 90 % of the starts."""
    simulated: Count
    """The same where the best of several simulated schedules is carried out."""
    answered: Count | None = None
    """The same for whole answers; None where it was not measured."""
    chosen_mean: Share
    """Success rate of the one choice, mean over the tasks."""
    simulated_mean: Share


def held_out_results(robot_name: str, controller: Controller) -> list[HeldOut]:
    """Results on the formulas and families that no weights are trained on.

    Robots that are simulated in true physics, which takes seconds, are tried on fewer.
    """
    shipped = [f"{robot_name}-{number}" for number in SHIPPED_HELD_OUT]
    known = set(task_names(robot_name)) | {f"{robot_name}-demo"}
    formulas = [build_task(load_task(name)) for name in shipped if name in known]
    found = [_results("formulas", formulas, controller)] if formulas else []
    for family in HELD_OUT:
        first = mission(robot_name, family, REPORTED).task
        count = 8 if physics_of(first.robot) is None else 2
        others = (mission(robot_name, family, REPORTED + n).task for n in range(1, count))
        found.append(_results(family, [first, *others], controller))
    return found


class Rates(NamedTuple):
    """Success rates on one task."""

    chosen: float
    """Of the critic's one choice."""
    simulated: float
    """Of the best of several schedules that are simulated."""
    answered: float
    """Of whole answers: more schedules, and nudges, where none of those satisfies."""
    seconds: tuple[float, ...]
    """Time of each simulated answer; the first may have compiled."""


def rates(task: Task, controller: Controller, *, states: int, starts: int) -> Rates:
    """Success rates from random initial states.

    Args:
        task: the grounded task.
        controller: made of the weights.
        states: initial states for the one choice.
        starts: initial states for the simulated answers.
    """
    chosen = evaluate(task, controller, jax.random.key(0), count=states).success_rate
    initial = start_states(task.problem, jax.random.key(1), count=starts)
    answers = [answer(task, controller, state) for state in initial]
    answered = np.array([found.plan.satisfied for found in answers])
    simulated = answered & [found.rounds == 1 for found in answers]
    seconds = tuple(found.seconds for found in answers)
    return Rates(chosen, float(simulated.mean()), float(answered.mean()), seconds)


def summary(name: str, found: Sequence[Rates]) -> HeldOut:
    """Results on the tasks of a set together."""
    chosen, simulated, answered = np.array([row[:3] for row in found]).T
    return HeldOut(
        name=name,
        tasks=len(found),
        chosen=int((chosen >= GOOD).sum()),
        simulated=int((simulated >= GOOD).sum()),
        answered=int((answered >= GOOD).sum()),
        chosen_mean=float(chosen.mean()),
        simulated_mean=float(simulated.mean()),
    )


def _results(name: str, tasks: list[Task], controller: Controller) -> HeldOut:
    states, starts = (128, 16) if physics_of(tasks[0].robot) is None else (32, 8)
    return summary(name, [rates(task, controller, states=states, starts=starts) for task in tasks])
