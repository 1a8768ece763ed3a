"""A rollout as the page shows it: states on the host, the verdict, and each task's outcome."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from core.between import Between, between, breach_text
from core.decompose import Kind, task_name
from core.evaluation import verdicts
from core.monitor import Diagnosis, MonitorRow, diagnose, leaf_status, monitor_rows
from core.settled import retimed, times_met
from core.stl import robustness, to_math
from core.task.task import Task


@dataclass(frozen=True)
class Outcome:
    """How one task of the formula fared in its window."""

    name: str
    predicate: str
    kind: Kind
    start: int
    end: int
    margin: np.ndarray
    """Margin of the predicate at each step of the episode [T] in [m], >= 0 where it holds."""

    @property
    def worst(self) -> float:
        """Smallest margin in the window [m]; +inf for an empty window."""
        return float(self.margin[self.start : self.end + 1].min(initial=np.inf))

    @property
    def first_failure(self) -> int | None:
        """First step of the window at which the predicate does not hold."""
        failed = np.flatnonzero(self.margin[self.start : self.end + 1] < 0)
        return int(self.start + failed[0]) if failed.size else None


@dataclass(frozen=True, eq=False)
class Recording:
    """One rollout of one schedule; steps 0 to T."""

    task: Task
    schedule: tuple[int, ...]
    states: np.ndarray  # [T + 1, n]
    actions: np.ndarray  # [T, m] as the policy gave them, before clipping
    margins: np.ndarray  # [T + 1, A] of the regions [m]
    positions: np.ndarray  # [T + 1, 3] in [m], z = 0 for planar robots
    robustness: float  # of the formula [m], -inf if the simulation diverged; see `satisfied`
    outcomes: tuple[Outcome, ...]
    moves: tuple[int, ...] = ()
    """Steps at which somebody has put the robot somewhere else."""
    between: Between = Between(np.inf)
    """What it does between the steps."""
    nudged: bool = False
    """Whether the policy alone does not repeat it (see `core.nudges`)."""

    @property
    def satisfied(self) -> bool:
        """The verdict: exact satisfaction of the formula by the simulated trace.

        Where the scene asks for it, between the steps, too.
        """
        return self.robustness >= 0

    @property
    def steps(self) -> int:
        """T."""
        return len(self.states) - 1

    def schedule_for(self, task: Task | None) -> tuple[int, ...] | None:
        """Its schedule, if it is one of this task: the formula may have been edited since."""
        if task is None:
            return None
        own, others = self.task.grounding.decomposition, task.grounding.decomposition
        return self.schedule if own.variables == others.variables else None

    @cached_property
    def diagnosis(self) -> Diagnosis:
        """What decided the verdict."""
        names = self.task.grounding.atoms
        found = diagnose(self.task.formula, self.margins, names, self.task.robot.dt)
        if self.satisfied or not found.satisfied:
            return found
        sentence = f"Violated: it holds at every step, but {breach_text(self.between)}."
        return Diagnosis(False, self.robustness, sentence, self.between.step)

    @cached_property
    def rows(self) -> tuple[MonitorRow, ...]:
        """Every subformula along the trace, parents first."""
        return monitor_rows(self.task.formula, self.margins, self.task.grounding.atoms)

    @cached_property
    def status(self) -> np.ndarray:
        """`LeafStatus` of every task of the decomposition at every step [K, T + 1]."""
        grounding = self.task.grounding
        return leaf_status(grounding.decomposition, self.schedule, self.margins, grounding.atoms)

    def status_at(self, position: float) -> np.ndarray:
        """`LeafStatus` [K] at a position [steps]."""
        return self.status[:, min(max(int(position), 0), self.steps)]


def record(
    task: Task,
    schedule: Any,
    states: np.ndarray,
    actions: np.ndarray,
    margins: np.ndarray,
    *,
    moves: tuple[int, ...] = (),
    nudged: bool = False,
) -> Recording:
    """Judge one simulated trace.

    Args:
        task: the grounded task.
        schedule: values of the variables [V], padding included or not; None where there was none:
            then the times at which the trace has met its tasks.
        states: [L + 1, n], L at least the task's horizon.
        actions: [L, m].
        margins: [L + 1, A] of the atoms [m], padding included or not.
        moves: steps at which somebody has put the robot somewhere else.
        nudged: whether its actions were nudged: then times at which it satisfies the formula
            replace those of the schedule that it missed.
    """
    length = task.horizon + 1
    states, actions = np.asarray(states)[:length], np.asarray(actions)[: length - 1]
    margins = np.asarray(margins)[:length, : len(task.grounding.atoms)]
    if schedule is None:
        schedule = times_met(task, margins)
    chosen = task.grounding.decomposition.own_values(schedule)
    position = np.asarray(task.robot.position(states))  # pyright: ignore[reportArgumentType]
    flat = np.zeros((length, 3))
    flat[:, : position.shape[1]] = position
    verdict = float(verdicts(task, states[:, None], margins[:, None])[0])
    outcomes, found = _outcomes(task, chosen, margins), between(task, states)
    if nudged and verdict >= 0 and _missed(outcomes):
        again = retimed(task, chosen, margins)
        if not _missed(met := _outcomes(task, again, margins)):
            chosen, outcomes = again, met
    return Recording(
        task, chosen, states, actions, margins, flat, verdict, outcomes, moves, found, nudged
    )


def _missed(outcomes: tuple[Outcome, ...]) -> bool:
    return any(outcome.worst < 0 for outcome in outcomes)


def _outcomes(task: Task, schedule: tuple[int, ...], margins: np.ndarray) -> tuple[Outcome, ...]:
    decomposition, names = task.grounding.decomposition, task.grounding.atoms
    index = {id(one): i for i, one in enumerate(decomposition.tasks)}
    atoms = margins[:, None, : len(names)]
    return tuple(
        Outcome(
            task_name(decomposition, index[id(one)]),
            to_math(one.predicate),
            one.kind,
            start,
            end,
            np.asarray(robustness(one.predicate, atoms, names)),
        )
        for one, start, end in decomposition.active_tasks(schedule)
        if start <= end
    )
