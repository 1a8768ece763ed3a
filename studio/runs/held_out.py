"""What weights reach on tasks that they were not trained on."""

from collections.abc import Sequence
from typing import Annotated, NamedTuple

import jax
import msgspec
import numpy as np
from msgspec import Meta

from core.answer import Effort, answer
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


ONE_ROUND = Effort(rounds=1)

Count = Annotated[int, Meta(ge=0)]


class HeldOut(msgspec.Struct, kw_only=True, frozen=True):
    """Results on a set of tasks."""

    name: str
    tasks: Count
    chosen: Count
    """Tasks that the critic's one choice solves from at least 90 % of the starts."""
    simulated: Count
    """The same where the best of several simulated schedules is carried out."""
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
    rounds: tuple[int, ...]
    """Rounds of each answer until it satisfied the formula; 0 where it does not."""
    seconds: tuple[float, ...]
    """Time of each answer; the first may have compiled."""

    @property
    def simulated(self) -> float:
        """Of the best of several schedules that are simulated: answers of one round."""
        return float(np.mean(np.array(self.rounds) == 1))

    @property
    def answered(self) -> float:
        """Of answers of all their rounds."""
        return float(np.mean(np.array(self.rounds) > 0))


def rates(
    task: Task, controller: Controller, *, states: int, starts: int, effort: Effort = ONE_ROUND
) -> Rates:
    """Success rates from random initial states.

    Args:
        task: the grounded task.
        controller: made of the weights.
        states: initial states for the one choice.
        starts: initial states for the answers.
        effort: of each answer.
    """
    chosen = evaluate(task, controller, jax.random.key(0), count=states).success_rate
    initial = start_states(task.problem, jax.random.key(1), count=starts)
    answers = [answer(task, controller, state, effort=effort) for state in initial]
    rounds = tuple(found.rounds if found.plan.satisfied else 0 for found in answers)
    return Rates(chosen, rounds, tuple(found.seconds for found in answers))


def summary(name: str, found: Sequence[Rates]) -> HeldOut:
    """Results on the tasks of a set together."""
    chosen, simulated = np.array([(row.chosen, row.simulated) for row in found]).T
    return HeldOut(
        name=name,
        tasks=len(found),
        chosen=int((chosen >= GOOD).sum()),
        simulated=int((simulated >= GOOD).sum()),
        chosen_mean=float(chosen.mean()),
        simulated_mean=float(simulated.mean()),
    )


def _results(name: str, tasks: list[Task], controller: Controller) -> HeldOut:
    states, starts = (128, 16) if physics_of(tasks[0].robot) is None else (32, 8)
    return summary(name, [rates(task, controller, states=states, starts=starts) for task in tasks])
