"""Which task of a formula stands in the way of a controller that never succeeds.

Rolled out from random initial states, each with the schedule of the controller's choice, every
rollout fails some tasks: a predicate does not hold somewhere in its window. The task that fails
most often is told, with the step at which it usually begins to fail.

Dimensions: R rollouts, T steps, A atoms.
"""

from typing import NamedTuple

import numpy as np

from core.between import swept
from core.controller import Controller
from core.decompose import task_name
from core.quoting import LONGEST_FORMULA, shown
from core.rollout import roll_out_choice
from core.stl import robustness_signal, to_text
from core.task.protocols import Array
from core.task.task import Task


class Failure(NamedTuple):
    """The task that fails most often."""

    task: int
    """Its index among the tasks of the decomposition."""
    share: float
    """Of the rollouts, in which it fails."""
    step: int
    """Median of the first steps at which it fails."""


def commonest_failure(
    task: Task, controller: Controller, key: Array, *, count: int
) -> Failure | None:
    """The task that fails in most of R = count rollouts, the earlier one of equals.

    None if no task fails, or there is none.
    """
    schedules, _, rollout = roll_out_choice(task, controller, key, count=count)
    states, margins = (
        np.moveaxis(np.asarray(each), 0, 1) for each in (rollout.states, rollout.margins)
    )
    between = _between(task, states) if task.between_steps else None
    return _commonest(task, margins, np.asarray(schedules), between)


def failure_text(task: Task, failure: Failure) -> str:
    """`Subgoal 2 (C) fails in 98% of the rollouts, usually from step 5 on`."""
    decomposition = task.grounding.decomposition
    predicate = shown(to_text(decomposition.tasks[failure.task].predicate), LONGEST_FORMULA)
    return (
        f"what stands in the way: {task_name(decomposition, failure.task)} ({predicate}) fails in "
        f"{failure.share:.0%} of the rollouts, usually from step {failure.step} on"
    )


def _between(task: Task, states: np.ndarray) -> np.ndarray:
    """Whether each task's predicate holds from each step to the next [R, T - 1, K]."""
    predicates = [each.predicate for each in task.grounding.decomposition.tasks]
    return swept(task, states, predicates).value >= 0


def _commonest(
    task: Task, traces: np.ndarray, schedules: np.ndarray, between: np.ndarray | None = None
) -> Failure | None:
    """From margins [R, T, A] of the rollouts and their schedules [R, V].

    Args:
        task: whose tasks are meant.
        traces: margins.
        schedules: of the rollouts.
        between: whether each task holds from each step to the next, where that counts.
    """
    decomposition, names = task.grounding.decomposition, task.grounding.atoms
    used = len(decomposition.variables)
    held = [
        np.asarray(robustness_signal(each.predicate, traces[..., : len(names)], names)) >= 0
        for each in decomposition.tasks
    ]  # [R, T] each
    first: list[list[int]] = [[] for _ in decomposition.tasks]
    index = {id(each): number for number, each in enumerate(decomposition.tasks)}
    for rollout, schedule in enumerate(schedules[:, :used].tolist()):
        for each, start, end in decomposition.active_tasks(schedule):
            number = index[id(each)]
            missed = ~held[number][rollout, start : end + 1]
            if between is not None:
                missed[:-1] |= ~between[rollout, start:end, number]
            if missed.any():
                first[number].append(start + int(missed.argmax()))
    failing = [number for number, steps in enumerate(first) if steps]
    if not failing:
        return None
    worst = max(failing, key=lambda number: (len(first[number]), -np.median(first[number])))
    return Failure(worst, len(first[worst]) / len(schedules), int(np.median(first[worst])))
