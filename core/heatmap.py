"""A controller's scores over two time variables: the heatmap of the paper's Fig. 6.

Programs score a fixed number of schedules; larger maps are scored in several calls.

Dimensions: h x w cells, V variables, K alternatives for the variables that are not on the axes.
"""

from collections.abc import Mapping
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import program
from core.controller import Controller
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.task import Task
from core.task.windows import RESERVE, TightLeg, leg_slack, tightest_leg, windows_of

RESOLUTION = 100
"""Maximum number of cells along an axis; larger domains are sampled evenly, ends included."""

COARSE = 48
"""The same for a heatmap of the best over the rest, which scores many schedules per cell."""

ALTERNATIVES = 16
"""Values of the rest that such a heatmap tries."""

BATCH = 4096
"""Schedules that the compiled program scores at a time."""


class Heatmap(NamedTuple):
    """Scores of schedules over two variables, the others fixed or the best of several.

    Row i belongs to `second[i]`, column j to `first[j]`; with one variable there is one row.
    """

    axes: tuple[int, ...]  # variables on the axes: (), (x,) or (x, y)
    first: np.ndarray  # [w] values of the variable on the x axis [steps]
    second: np.ndarray  # [h] values of the variable on the y axis
    values: np.ndarray  # [h, w] the controller's scores
    shortfall: np.ndarray  # [h, w] steps by which the schedule's legs are too short
    schedule: np.ndarray  # [V] the schedule whose other entries are held fixed
    schedules: np.ndarray | None = None  # [h, w, V] where they are not
    legs: TightLeg | None = None  # [h, w] each: the leg with the least to spare

    def schedule_at(self, row: int, column: int) -> np.ndarray:
        """Schedule [V] of a cell."""
        if self.schedules is not None:
            return self.schedules[row, column]
        schedule = self.schedule.copy()
        for axis, value in zip(self.axes, (self.first[column], self.second[row]), strict=False):
            schedule[axis] = value
        return schedule


class Scores(NamedTuple):
    """What the controller and the geometry say about N schedules."""

    values: np.ndarray  # [N]
    shortfall: np.ndarray  # [N] [steps]
    legs: TightLeg  # [N] each


def heatmap(
    task: Task,
    controller: Controller,
    state: Array,
    schedule: np.ndarray,
    axes: tuple[int, ...],
    rest: np.ndarray | None = None,
) -> Heatmap:
    """Score a grid of schedules.

    Args:
        task: the grounded task.
        controller: what scores the schedules.
        state: initial state [n].
        schedule: values [V] of the variables that are not on the axes.
        axes: zero, one or two variables.
        rest: schedules [K, V] whose entries off the axes are tried in each cell, the best kept,
            instead of those of `schedule`.
    """
    most = RESOLUTION if rest is None else COARSE
    first, second = [_domain(task, axis, most) for axis in axes] + [np.zeros(1, np.int32)] * (
        2 - len(axes)
    )
    tried = np.asarray(schedule, np.int32)[None] if rest is None else np.asarray(rest, np.int32)
    grid = np.tile(tried, (second.size, first.size, 1, 1))  # [h, w, K, V]
    if axes:
        grid[:, :, :, axes[0]] = first[None, :, None]
    if len(axes) > 1:
        grid[:, :, :, axes[1]] = second[:, None, None]
    scores = score(task, controller, state, grid.reshape(-1, grid.shape[-1]))
    values = scores.values.reshape(grid.shape[:3])
    best = np.nan_to_num(values, nan=-np.inf).argmax(-1)[..., None]

    def chosen(flat: np.ndarray) -> np.ndarray:
        return np.take_along_axis(flat.reshape(grid.shape[:3]), best, -1)[..., 0]

    return Heatmap(
        axes,
        first,
        second,
        chosen(scores.values),
        chosen(scores.shortfall),
        np.asarray(schedule),
        np.take_along_axis(grid, best[..., None], 2)[:, :, 0],
        jax.tree.map(chosen, scores.legs),
    )


def score(task: Task, controller: Controller, state: Array, schedules: np.ndarray) -> Scores:
    """Score, shortfall and tightest leg of schedules [N, V] from a state [n]."""
    parts = []
    for start in range(0, len(schedules), BATCH):
        batch = np.zeros((BATCH, *task.problem.formula.low.shape), np.int32)
        piece = schedules[start : start + BATCH]
        batch[: len(piece)] = piece
        parts.append(_score(task.problem, controller, state, jnp.asarray(batch)))
    joined = jax.tree.map(lambda *leaves: np.concatenate(leaves)[: len(schedules)], *parts)
    return Scores(*joined)


@program
def _score(
    problem: Problem, controller: Controller, state: Array, schedules: Array
) -> tuple[Array, Array, TightLeg]:
    search = controller.search
    reserve = RESERVE if search is None else search.reserve
    position = problem.robot.position(state)

    def one(schedule: Array):
        windows = windows_of(problem, schedule)
        _, short = leg_slack(problem, windows, position, reserve)
        leg = tightest_leg(problem, windows, position, reserve)
        return controller.score(problem, state, schedule), short, leg

    return jax.vmap(one)(schedules)


def best_schedule(
    task: Task,
    controller: Controller,
    state: Array,
    fixed: Mapping[int, int],
) -> np.ndarray:
    """The schedule [V] that scores highest of many drawn with some entries fixed."""
    drawn = random_schedules(task, BATCH, fixed)
    scores = score(task, controller, state, drawn)
    return drawn[np.nan_to_num(scores.values, nan=-np.inf).argmax()]


def random_schedules(task: Task, count: int, fixed: Mapping[int, int]) -> np.ndarray:
    """Schedules [N, V], uniform except for the fixed entries; the same at every call."""
    formula = task.problem.formula
    low, high = np.asarray(formula.low), np.asarray(formula.high)
    drawn = np.random.default_rng(0).integers(low, high + 1, (count, low.size))
    for variable, value in fixed.items():
        drawn[:, variable] = value
    return drawn.astype(np.int32)


def _domain(task: Task, axis: int, most: int) -> np.ndarray:
    variable = task.grounding.decomposition.variables[axis]
    count = min(variable.high - variable.low + 1, most)
    return np.unique(np.linspace(variable.low, variable.high, count).round().astype(np.int32))
