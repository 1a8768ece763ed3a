"""Which of a schedule's times the past settles, and between which values the others are left.

A time is settled where a subgoal that was met, or a stay that has begun and held until now, rests
on it. A time of a subgoal that has failed is open again.

Dimensions: V variables, A atoms.
"""

from collections.abc import Mapping

import numpy as np

from core.decompose import Kind, Subtask
from core.monitor import LeafStatus, Signals, leaf_status
from core.task.grounding import FormulaArrays
from core.task.task import Task

Settled = Mapping[int, int]
"""Values of the variables that are settled, by index."""


def settled_by_schedule(task: Task, schedule: tuple[int, ...], margins: np.ndarray) -> Settled:
    """What a schedule [V] was met by: margins [k + 1, A] of the trace so far."""
    decomposition = task.grounding.decomposition
    status = leaf_status(decomposition, schedule, margins, task.grounding.atoms)[:, -1]
    kept: set[int] = set()
    for leaf, state in zip(decomposition.tasks, status, strict=True):
        begun = leaf.start.at(schedule) < len(margins)
        if leaf.kind is not Kind.INVARIANT and begun and state in (_MET, _HOLDING):
            kept |= _variables(leaf)
    for leaf, state in zip(decomposition.tasks, status, strict=True):
        if state == LeafStatus.VIOLATED and _variables(leaf) <= kept:
            kept -= _variables(leaf)
    return {index: schedule[index] for index in sorted(kept)}


def settled_by_chance(
    task: Task, schedule: tuple[int, ...], margins: np.ndarray, settled: Settled
) -> Settled:
    """The settled values and those at which the trace has met further subgoals unasked.

    Of several values the one with the largest margin counts. Variables are tried in their order,
    so that a time that counts from another comes after it.
    """
    signals = Signals(margins, task.grounding.atoms)
    found = dict(settled)
    for index, variable in enumerate(task.grounding.decomposition.variables):
        if index in found or variable.kind == "branch":
            continue
        values = range(variable.low, min(variable.high, len(margins) - 1) + 1)
        worth = [_worth(task, schedule, signals, found | {index: value}, index) for value in values]
        if worth and max(worth) >= 0:
            found[index] = values[int(np.argmax(worth))]
    return found


def times_met(task: Task, margins: np.ndarray) -> tuple[int, ...]:
    """Times at which a whole trace [T + 1, A] has met what it could, of one that had no schedule.

    Where a time's subgoals were never met it is the earliest, and so is the branch.
    """
    low = tuple(variable.low for variable in task.grounding.decomposition.variables)
    met = settled_by_chance(task, low, margins, {})
    return tuple(met.get(index, value) for index, value in enumerate(low))


def retimed(task: Task, schedule: tuple[int, ...], margins: np.ndarray) -> tuple[int, ...]:
    """A schedule whose missed times are those at which a whole trace [T + 1, A] met what it could.

    Nudged actions may satisfy the formula at other times than those that the controller was given.
    """
    met = settled_by_schedule(task, schedule, margins)
    found = settled_by_chance(task, schedule, margins, met)
    return tuple(found.get(index, value) for index, value in enumerate(schedule))


def reopened(task: Task, settled: Settled) -> Settled:
    """What stays settled where every time is given up that an open one is tied to.

    Two variables are tied where one task rests on both, or through others: for `F(A & F B)` a visit
    to A that came too early for B can be made again.
    """
    ties = [_variables(leaf) for leaf in task.grounding.decomposition.tasks]
    free = set(range(len(task.grounding.decomposition.variables))) - settled.keys()
    for _ in ties:
        free |= {index for tie in ties if tie & free for index in tie}
    return {index: value for index, value in settled.items() if index not in free}


def left_open(task: Task, settled: Settled, step: int) -> FormulaArrays:
    """The formula with the domains that are left after a step.

    Settled variables keep their value. A variable that alone decides when a subgoal begins is at
    least such that it does not begin before the step.
    """
    formula = task.problem.formula
    low, high = np.array(formula.low), np.array(formula.high)
    for index, value in settled.items():
        low[index] = high[index] = value
    for index in range(len(task.grounding.decomposition.variables)):
        least = [
            step - leaf.start.offset - sum(settled[i] for i in leaf.start.variables if i != index)
            for leaf in task.grounding.subgoals
            if leaf.start.variables.count(index) == 1
            and all(i in settled for i in leaf.start.variables if i != index)
        ]
        if index not in settled and least:
            low[index] = np.clip(min(least), low[index], high[index])
    return formula._replace(low=low, high=high)


_MET, _HOLDING = LeafStatus.MET, LeafStatus.HOLDING


def _variables(leaf: Subtask) -> set[int]:
    """Everything that decides whether and when a task holds."""
    guards = {index for index, _ in leaf.guards}
    return guards | set(leaf.start.variables) | set(leaf.end.variables)


def _worth(
    task: Task, schedule: tuple[int, ...], signals: Signals, settled: Settled, index: int
) -> float:
    """Least margin [m] of the subgoals that a settled variable decides; -inf where one is left."""
    values = [settled.get(i, value) for i, value in enumerate(schedule)]
    worst = np.inf
    for leaf in task.grounding.subgoals:
        matters = all(values[i] == wanted for i, wanted in leaf.guards)
        used = set(leaf.start.variables) | set(leaf.end.variables)
        if index not in used or not matters or not used <= settled.keys():
            continue
        start, end = leaf.start.at(values), leaf.end.at(values)
        signal = signals[leaf.predicate]
        if end >= len(signal):
            return -np.inf
        worst = min(worst, float(signal[start : end + 1].min(initial=np.inf)))
    return worst if np.isfinite(worst) else -np.inf
