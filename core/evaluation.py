"""Success rates by the paper's protocol (Sec. 5.1): exact verdicts on simulated traces.

A controller that chooses times has one rollout of its one choice from each initial state. One that
does not has several attempts (ten), and the trace of the highest robustness counts.
"""

import math
from typing import NamedTuple

import jax
import numpy as np

from core.controller import Controller
from core.rollout import roll_out, roll_out_choice
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

    @property
    def success_rate(self) -> float:
        """Share of the traces that satisfy the formula."""
        return float((self.robustness >= 0).mean())

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


def evaluate(
    task: Task, controller: Controller, key: Array, *, count: int = EVALUATION_STATES
) -> Evaluation:
    """Roll out the controller's choice from each of R random initial states, by each attempt."""
    schedules, scores, rollout = roll_out_choice(task, controller, key, count=count)
    verdicts = trace_robustness(task, np.asarray(rollout.margins))
    for attempt in controller.attempts[1:]:
        again = roll_out(task, attempt, rollout.states[0], schedules)
        verdicts = np.maximum(verdicts, trace_robustness(task, np.asarray(again.margins)))
    return Evaluation(verdicts, np.asarray(schedules), np.asarray(scores))


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
