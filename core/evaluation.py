"""Success rates by the paper's protocol (Sec. 5.1): one schedule, one rollout, exact verdicts."""

import math
from dataclasses import replace
from typing import NamedTuple

import jax
import numpy as np

from core.networks import Parameters
from core.programs import EvaluationPrograms
from core.protocols import Array
from core.stl import robustness
from core.task import Task


class Evaluation(NamedTuple):
    """Verdicts of R rollouts from random initial states."""

    robustness: np.ndarray  # [R] of the formula on the simulated traces [m]
    schedules: np.ndarray  # [R, V] that the critic chose
    values: np.ndarray  # [R] the critic's values of them

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
        """Simulations that broke down; they have failed."""
        return int((self.robustness == -np.inf).sum())


def trace_robustness(task: Task, margins: np.ndarray) -> np.ndarray:
    """Robustness [R] of the task's formula on margins [L + 1, R, A] of simulated traces.

    A trace with a number that is not finite has failed: its robustness is -inf.
    """
    names = task.grounding.atoms
    traces = np.moveaxis(np.asarray(margins)[: task.horizon + 1, :, : len(names)], 0, 1)
    value = np.asarray(robustness(task.formula, traces, names))
    return np.where(np.isfinite(traces).all((1, 2)), value, -np.inf)


def evaluate(
    task: Task, programs: EvaluationPrograms, parameters: Parameters, key: Array
) -> Evaluation:
    """Roll out the critic's choice once from each of R random initial states."""
    initial_key, choice_key = jax.random.split(key)
    states = programs.initial(task.problem, initial_key)
    schedules, values = programs.choose(task.problem, parameters, choice_key, states)
    rollout = programs.roll_out(task.problem, parameters, states, schedules)
    score = trace_robustness(task, np.asarray(rollout.margins))
    return Evaluation(score, np.asarray(schedules), np.asarray(values))


def evaluate_layouts(
    task: Task, programs: EvaluationPrograms, parameters: Parameters, key: Array
) -> Evaluation:
    """`evaluate` on the task's own layout and on those that it holds out, all together."""
    if task.layouts is None:
        return evaluate(task, programs, parameters, key)
    parts = []
    for problem in (task.problem, *task.layouts.held_out):
        key, part_key = jax.random.split(key)
        parts.append(evaluate(replace(task, problem=problem), programs, parameters, part_key))
    return Evaluation(*map(np.concatenate, zip(*parts, strict=True)))
