"""Ascent: the actions of attempts climb the robustness through the robot's own model.

But for its sign, the robustness of a trace is the margin of one atom at one step, the *deciding*
one, so the gradient of that margin with respect to the actions is the robustness's own wherever it
has one. No formula is part of the compiled program. Steps are Polyak's, as long as would take a
linear margin to a target, with momentum: the deciding margin changes from step to step.

The climb is open-loop. What it ends with is told as nudges, the part of the actions that is not
the controller's along the climbed trace, so that attempts are of one sort. Those that end short of
the formula are dropped: nudged on, they were measured to lead nowhere and to crowd out others.

Robots that are simulated in true physics have no gradient here.

Dimensions: P attempts, L steps, n state, m action, A atoms, V variables.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import jax
import jax.numpy as jnp
import numpy as np

from core.attempts import Attempt, Scheduled, tries
from core.compilation import compile_together, program, shape_of
from core.controller import Controller
from core.deciding import deciding_margin
from core.evaluation import verdicts
from core.rollout import carried, roll_on, roll_on_jobs
from core.task.physics import physics_of
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.task import Task

STEPS, PATIENCE = 60, 20
"""Most steps of a climb, and most without a new best of all attempts."""

TARGET = 0.1
"""Robustness that each step makes for [robot lengths]."""

MOMENTUM = 0.8

LONGEST = 0.5
"""Largest change of an action by one gradient; actions are in [-1, 1]."""

FLAT = 1e-9
"""Squared norm of a gradient that leads nowhere."""


class Climbing(Scheduled, Protocol):
    """An attempt that was carried out."""

    @property
    def actions(self) -> np.ndarray:
        """[L, m]."""
        ...


@dataclass(frozen=True, eq=False)
class Climb:
    """Makes attempts from one beginning more robust; none in true physics."""

    task: Task
    controller: Controller
    states: np.ndarray
    """[L + 1, n], of which steps 0 to `known` are fixed."""
    known: int

    def prepare(self, count: int) -> float:
        """Compile what climbs of P = count attempts need; returns the time that took [s]."""
        return compile_together(*ascent_jobs(self.task, self.controller, count))

    def __call__(self, attempts: Sequence[Climbing]) -> list[Attempt]:
        """Those of the P attempts that come to satisfy the formula, with the nudges for it."""
        if physics_of(self.task.robot) is not None:
            return []
        task, count = self.task, len(attempts)
        past = jnp.asarray(np.repeat(self.states[:, None], count, 1))
        known = jnp.full(count, self.known, jnp.int32)
        now = np.stack([each.actions for each in attempts], 1).clip(-1, 1).astype(np.float32)
        best, kept, traces = np.full(count, -np.inf), now, np.asarray(past)
        speed, goal, last = np.zeros_like(now), TARGET * task.robot.length, 0
        for number in range(STEPS):
            rollout = _carried(task.problem, past, known, jnp.asarray(now))
            states, margins = map(np.asarray, rollout)
            found = verdicts(task, states, margins)
            last = number if found.max() > best.max() else last
            better = found > best
            best = np.where(better, found, best)
            kept = np.where(better[:, None], now, kept)
            traces = np.where(better[:, None], states, traces)
            if best.max() >= goal or number - last == PATIENCE:
                break
            speed = MOMENTUM * speed + _step(task, past, known, now, found, margins)
            now = np.clip(now + speed, -1, 1)
        there = [int(index) for index in np.flatnonzero(best >= 0)]
        if not there:
            return []
        schedules = np.stack([attempts[index].schedule for index in there])
        nudges = kept[:, there] - self._led(traces[:, there], schedules)
        nudges[: self.known] = 0
        return [
            Attempt(attempts[index].schedule, attempts[index].kind, nudges[:, column])
            for column, index in enumerate(there)
        ]

    def _led(self, traces: np.ndarray, schedules: np.ndarray) -> np.ndarray:
        """What the controller would do [L, P, m] along traces [L + 1, P, n]."""
        task, count = self.task, len(schedules)
        rows = np.resize(np.arange(count), tries(task))  # the program that moves have, too
        end = np.full(len(rows), task.padded_horizon)
        led = roll_on(task, self.controller, traces[:, rows], end, schedules[rows])
        return np.asarray(led.actions)[:, :count]


def ascent_jobs(task: Task, controller: Controller, count: int) -> list[Callable[[], Any]]:
    """Compilations that climbs of P = count attempts need; none in true physics."""
    if physics_of(task.robot) is not None:
        return []
    steps, robot = task.padded_horizon, task.robot
    past = shape_of(steps + 1, count, robot.state_size, dtype=jnp.float32)
    actions = shape_of(steps, count, robot.action_size, dtype=jnp.float32)
    each = shape_of(count, dtype=jnp.int32)
    return [
        partial(_carried.compile, task.problem, past, each, actions),
        partial(_slope.compile, task.problem, past, each, actions, each, each),
        *roll_on_jobs(task, controller, tries(task)),
    ]


def _step(
    task: Task,
    past: Array,
    known: Array,
    actions: np.ndarray,
    robustness: np.ndarray,
    margins: np.ndarray,
) -> np.ndarray:
    """A step [L, P, m] that would raise each robustness [P] to the target, were it linear."""
    read = margins[: task.horizon + 1, :, : len(task.grounding.atoms)]
    deciding = [deciding_margin(value, read[:, index]) for index, value in enumerate(robustness)]
    steps, atoms, signs = (
        np.array([0 if each is None else each[part] for each in deciding], np.int32)
        for part in range(3)
    )
    at = jnp.asarray(steps), jnp.asarray(atoms)
    slope = np.asarray(_slope(task.problem, past, known, jnp.asarray(actions), *at))
    slope = np.nan_to_num(slope, posinf=0, neginf=0) * signs[:, None]
    bound = (np.abs(actions) >= 1) & (np.sign(slope) == np.sign(actions))
    slope = np.where(bound, 0, slope)
    norm = (slope**2).sum((0, 2))
    missing = TARGET * task.robot.length - robustness
    length = np.where(norm > FLAT, missing / np.maximum(norm, FLAT), 0)
    return np.clip(slope * length[:, None], -LONGEST, LONGEST).astype(np.float32)


_carried = program(carried)


@program
def _slope(
    problem: Problem, past: Array, known: Array, actions: Array, steps: Array, atoms: Array
) -> Array:
    """Gradients [L, P, m] of the margin of one atom [P] at one step [P] of each attempt."""

    def total(actions: Array) -> Array:
        _, margins = carried(problem, past, known, actions)
        return margins[steps, jnp.arange(steps.size), atoms].sum()

    return jax.grad(total)(actions)
