"""The map of a subject's schedules: two variables on the axes, the others fixed or chosen."""

from dataclasses import dataclass

import jax
import jax.numpy as jnp
import numpy as np

from core.candidates import ranked
from core.heatmap import ALTERNATIVES, Heatmap, best_schedule, heatmap, random_schedules
from core.task.protocols import Array
from core.task.task import Task
from core.truth import Truth, nothing_simulated, simulate_more
from studio.page.subject import Subject
from studio.runs.tasks import initial_state


@dataclass(frozen=True)
class MapView:
    """What a heatmap shows of a space of more than two variables."""

    axes: tuple[int, ...] | None = None
    """Variables on the axes; None for the first that matter."""
    fixed: tuple[tuple[int, int], ...] = ()
    """(variable, value) set by hand; the critic chooses the others."""
    best: bool = False
    """Whether each cell has the best of the times that are neither fixed nor on the axes."""


@dataclass(frozen=True, eq=False)
class Picture:
    """A heatmap and the schedule that scores highest."""

    subject: Subject
    heatmap: Heatmap
    choice: tuple[int, ...]
    start: tuple[float, ...] | None = None
    """Position at which its schedules begin [d] in [m]; None for the initial set's centre."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """What simulation says of a picture's cells, as far as it has come."""

    picture: Picture
    truth: Truth


def draw_picture(
    subject: Subject,
    view: MapView,
    start: tuple[float, ...] | None,
    plan: tuple[int, ...] | None = None,
) -> Picture:
    """The heatmap over two variables.

    The others are fixed by hand, or else those of the plan; without one the critic chooses.
    """
    task, fixed = subject.task, dict(view.fixed)
    state = initial_state(task, start)
    if fixed:
        found = best_schedule(task, subject.controller, state, fixed)
        choice = task.grounding.decomposition.own_values(found)
    elif plan is not None:
        choice = plan
    else:
        choice = _choice(subject, state)
    axes = default_axes(task, choice) if view.axes is None else view.axes
    rest = _alternatives(task, choice, fixed) if view.best else None
    drawn = heatmap(task, subject.controller, state, padded(task, choice), axes, rest)
    return Picture(subject, drawn, best_cell(drawn)[: len(choice)], start)


def simulate_picture(picture: Picture, before: Simulated | None) -> Simulated:
    """Simulate a few more cells of a picture.

    Args:
        picture: whose cells.
        before: what was simulated last; dropped if it answers another question.
    """
    subject = picture.subject
    if before is None or before.picture is not picture:
        truth = nothing_simulated(picture.heatmap)
        if before is not None and _same_question(before, picture, truth):
            truth = truth._replace(robustness=before.truth.robustness)
    else:
        truth = before.truth
    state = initial_state(subject.task, picture.start)
    return Simulated(picture, simulate_more(subject.task, subject.controller, state, truth))


def _same_question(before: Simulated, picture: Picture, truth: Truth) -> bool:
    """Whether the same controller was to carry out the same schedules from the same start."""
    one, other = before.picture, picture
    return (
        one.subject is other.subject
        and one.start == other.start
        and np.array_equal(before.truth.schedules, truth.schedules)
    )


def _alternatives(task: Task, choice: tuple[int, ...], fixed: dict[int, int]) -> np.ndarray:
    """Schedules [K, V] in the branches of the choice, which comes first."""
    branches = set(range(len(choice))) - set(time_variables(task))
    held = {branch: choice[branch] for branch in branches} | fixed
    drawn = random_schedules(task, ALTERNATIVES, held)
    drawn[0] = padded(task, choice)
    return drawn


def best_cell(drawn: Heatmap) -> tuple[int, ...]:
    """Schedule [V] of the cell that scores highest."""
    values = np.nan_to_num(drawn.values, nan=-np.inf)
    row, column = np.unravel_index(values.argmax(), values.shape)
    return tuple(int(value) for value in drawn.schedule_at(int(row), int(column)))


def _choice(subject: Subject, state: Array) -> tuple[int, ...]:
    """The best of the schedules that the controller is offered for an answer."""
    task = subject.task
    best = ranked(task.problem, subject.controller, jax.random.key(0), state).schedules[0]
    return task.grounding.decomposition.own_values(best)


def default_axes(task: Task, choice: tuple[int, ...]) -> tuple[int, ...]:
    """The first two time variables that matter in the branches of a schedule."""
    variables = task.grounding.decomposition.variables
    matter = [
        index
        for index in time_variables(task)
        if all(choice[branch] == value for branch, value in variables[index].guards)
    ]
    return tuple(matter[:2])


def time_variables(task: Task) -> tuple[int, ...]:
    """Indices of the variables that are times (the others choose branches)."""
    variables = task.grounding.decomposition.variables
    return tuple(i for i, variable in enumerate(variables) if variable.kind == "time")


def padded(task: Task, schedule: tuple[int, ...]) -> np.ndarray:
    """A schedule of the formula's own variables as programs take it [V]."""
    row = np.zeros(task.problem.formula.low.shape, np.int32)
    row[: len(schedule)] = schedule
    return row


def repeated(row: Array, count: int) -> Array:
    """A row [n] as often as a program takes [R, n]."""
    return jnp.broadcast_to(row, (count, *row.shape))
