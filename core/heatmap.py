"""The critic over two time variables: the heatmap of the paper's Fig. 6."""

from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from core.algorithm import Algorithm
from core.grounding import MAX_VARIABLES
from core.networks import Parameters
from core.programs import scoring_program
from core.protocols import Array
from core.task import Task

RESOLUTION = 64
"""Most cells along an axis; wider domains are sampled evenly, ends included."""


class Heatmap(NamedTuple):
    """V(s_0, t) over two variables, the others fixed.

    Row i belongs to `second[i]`, column j to `first[j]`; with one variable there is one row.
    """

    axes: tuple[int, ...]  # variables on the axes: (), (x,) or (x, y)
    first: np.ndarray  # [w] values of the variable on the x axis [steps]
    second: np.ndarray  # [h] values of the variable on the y axis
    values: np.ndarray  # [h, w] critic, in units of the reward
    shortfall: np.ndarray  # [h, w] steps by which the schedule's legs are too short
    schedule: np.ndarray  # [V] the schedule whose other entries are held fixed

    def schedule_at(self, row: int, column: int) -> np.ndarray:
        """Schedule [V] of a cell."""
        schedule = self.schedule.copy()
        for axis, value in zip(self.axes, (self.first[column], self.second[row]), strict=False):
            schedule[axis] = value
        return schedule


def heatmap(
    task: Task,
    algorithm: Algorithm,
    parameters: Parameters,
    state: Array,
    schedule: np.ndarray,
    axes: tuple[int, ...],
) -> Heatmap:
    """Evaluate the critic on a grid of schedules.

    Args:
        task: the grounded task.
        algorithm: what the parameters were trained with.
        parameters: weights of both networks.
        state: initial state [n].
        schedule: values [V] of the variables that are not on the axes.
        axes: zero, one or two variables.
    """
    domains = [_domain(task, axis) for axis in axes] + [np.zeros(1, np.int32)] * (2 - len(axes))
    first, second = domains
    grid = np.tile(np.asarray(schedule, np.int32), (len(second), len(first), 1))
    if axes:
        grid[:, :, axes[0]] = first[None, :]
    if len(axes) > 1:
        grid[:, :, axes[1]] = second[:, None]
    flat = np.zeros((RESOLUTION**2, MAX_VARIABLES), np.int32)
    flat[: first.size * second.size] = grid.reshape(-1, MAX_VARIABLES)
    score = scoring_program(task, algorithm, RESOLUTION**2)
    values, shortfall = score(task.problem, parameters, state, jnp.asarray(flat))
    shape, used = (second.size, first.size), first.size * second.size
    return Heatmap(
        axes,
        first,
        second,
        np.asarray(values)[:used].reshape(shape),
        np.asarray(shortfall)[:used].reshape(shape),
        np.asarray(schedule),
    )


def _domain(task: Task, axis: int) -> np.ndarray:
    variable = task.grounding.decomposition.variables[axis]
    count = min(variable.high - variable.low + 1, RESOLUTION)
    return np.unique(np.linspace(variable.low, variable.high, count).round().astype(np.int32))
