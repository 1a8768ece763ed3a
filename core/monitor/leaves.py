"""Where each task of a decomposition stands at each step of a rollout."""

from collections.abc import Sequence
from enum import IntEnum

import numpy as np

from core.decompose import Decomposition, Subtask
from core.monitor.signals import Signals


class LeafStatus(IntEnum):
    """State of a task at a step, given the trace up to and including the step."""

    INACTIVE = 0
    """In a branch that the schedule does not take."""
    PENDING = 1
    """The window has not begun."""
    HOLDING = 2
    """Within the window; the predicate has held at every step of it so far."""
    MET = 3
    """The window is over, and the predicate held at every step of it; or the window is empty."""
    VIOLATED = 4
    """The predicate has failed at some step of the window."""


def leaf_status(
    decomposition: Decomposition,
    schedule: Sequence[int],
    margins: np.ndarray,
    names: Sequence[str],
) -> np.ndarray:
    """Status of every task at every step.

    Args:
        decomposition: of the formula.
        schedule: values of the variables [V], padding included or not.
        margins: [T, A] of one trace [m].
        names: of the columns.

    Returns:
        [K, T] values of `LeafStatus` (int8) in the order of `decomposition.tasks`; once a task is
        met or violated, it stays so. Every active task ends as met if and only if the trace
        carries out the schedule (given that it is as long as the formula's horizon).
    """
    signals = Signals(margins, names)
    chosen = decomposition.own_values(schedule)
    active = {id(task): (start, end) for task, start, end in decomposition.active_tasks(chosen)}
    status = np.zeros((len(decomposition.tasks), len(signals.margins)), np.int8)
    for row, task in zip(status, decomposition.tasks, strict=True):
        if id(task) in active:
            row[:] = _status(task, *active[id(task)], signals)
    return status


def _status(task: Subtask, start: int, end: int, signals: Signals) -> np.ndarray:
    step = np.arange(len(signals.margins))
    if start > end:
        return np.full(step.size, LeafStatus.MET)
    inside = (start <= step) & (step <= end)
    failed = np.logical_or.accumulate(inside & ~(signals[task.predicate] >= 0))
    calm = np.select(
        [step < start, step < end], [LeafStatus.PENDING, LeafStatus.HOLDING], LeafStatus.MET
    )
    return np.where(failed, LeafStatus.VIOLATED, calm)
