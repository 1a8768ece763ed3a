"""Success rates by the paper's protocol (Sec. 5.1): exact verdicts on simulated traces.

A controller that chooses times has one rollout of its one choice from each initial state. One that
does not has several attempts (ten), and the trace of the highest robustness counts.
"""

import math
from typing import NamedTuple

import jax
import numpy as np

from core.between import between_margins, strict_robustness
from core.controller import Controller
from core.rollout import Rollout, roll_out, roll_out_choice
from core.stl import robustness, samples_read
from core.task.protocols import Array
from core.task.task import Task

EVALUATION_STATES = 512
"""Initial states of an evaluation (Sec. 5.1)."""


class Evaluation(NamedTuple):
    """Verdicts from R random initial states."""

    robustness: np.ndarray  # [R] of the formula on the best trace from each [m]
    schedules: np.ndarray  # [R, V] that the controller chose
    scores: np.ndarray  # [R] the controller's scores of them
    between: np.ndarray  # [R] least margin between the steps [m]; NaN where it was not asked for

    @property
    def success_rate(self) -> float:
        """Share of the traces that satisfy the formula."""
        return float((self.robustness >= 0).mean())

    @property
    def between_rate(self) -> float | None:
        """Share of the satisfying traces whose invariants hold between the steps, too.

        None if there are none, or it was not asked for.
        """
        satisfying = self.between[self.robustness >= 0]
        if not satisfying.size or np.isnan(satisfying).any():
            return None
        return float((satisfying >= 0).mean())

    @property
    def robustness_mean(self) -> float:
        """Mean robustness of the traces that were simulated to the end [m]."""
        finite = self.robustness[np.isfinite(self.robustness)]
        return float(finite.mean()) if finite.size else -math.inf

    @property
    def diverged(self) -> int:
        """Simulations that broke down before the verdict; they have failed."""
        return int((self.robustness == -np.inf).sum())


def trace_robustness(task: Task, margins: np.ndarray) -> np.ndarray:
    """Robustness [R] of the task's formula on margins [L + 1, R, A] of simulated traces.

    A trace has failed where a number that the formula reads is not finite: its robustness is
    -inf.
    """
    names = task.grounding.atoms
    traces = np.moveaxis(np.asarray(margins)[: task.horizon + 1, :, : len(names)], 0, 1)
    value = np.asarray(robustness(task.formula, traces, names))
    sound = np.isfinite(traces) | ~samples_read(task.formula, traces.shape[1], names)
    return np.where(sound.all((1, 2)), value, -np.inf)


def rollout_robustness(task: Task, rollout: Rollout) -> np.ndarray:
    """What decides the success of rollouts: robustness [R] of the task's formula."""
    return verdicts(task, np.asarray(rollout.states), np.asarray(rollout.margins))


def verdicts(task: Task, states: np.ndarray, margins: np.ndarray) -> np.ndarray:
    """Robustness [R] that decides success, of traces with states [L + 1, R, n].

    That of `trace_robustness`; where the task asks for it, no more than the strict robustness.
    """
    value = trace_robustness(task, margins)
    if task.between_steps:
        finite = np.isfinite(value)
        traces = np.moveaxis(states, 0, 1)[finite]
        value[finite] = np.minimum(value[finite], strict_robustness(task, traces))
    return value


def evaluate(
    task: Task,
    controller: Controller,
    key: Array,
    *,
    count: int = EVALUATION_STATES,
    between: bool = False,
) -> Evaluation:
    """Roll out the controller's choice from each of R = count random initial states.

    By each of its attempts; the trace of the highest robustness counts.

    Args:
        task: the grounded task.
        controller: of what is evaluated.
        key: of initial states and choices.
        count: initial states.
        between: whether to look between the steps.
    """
    schedules, scores, rollout = roll_out_choice(task, controller, key, count=count)
    states, found = np.asarray(rollout.states), rollout_robustness(task, rollout)
    for attempt in controller.attempts[1:]:
        again = roll_out(task, attempt, rollout.states[0], schedules)
        value = rollout_robustness(task, again)
        better = value > found
        found = np.where(better, value, found)
        states = np.where(better[:, None], np.asarray(again.states), states)
    margins = np.full(count, np.nan)
    if between:
        satisfying = found >= 0
        margins[satisfying] = between_margins(task, np.moveaxis(states, 0, 1)[satisfying])
    return Evaluation(found, np.asarray(schedules), np.asarray(scores), margins)


def evaluate_layouts(
    task: Task, controller: Controller, key: Array, *, count: int = EVALUATION_STATES
) -> Evaluation:
    """`evaluate` on the task's own layout and its held-out layouts together."""
    if task.layouts is None:
        return evaluate(task, controller, key, count=count)
    tasks = (task, *task.layouts.held_out)
    parts = [
        evaluate(one, controller, part_key, count=count)
        for one, part_key in zip(tasks, jax.random.split(key, len(tasks)), strict=True)
    ]
    return Evaluation(*map(np.concatenate, zip(*parts, strict=True)))
