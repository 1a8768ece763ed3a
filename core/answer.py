"""An answer before training: schedules that the critic likes are simulated, the best is kept.

The critic ranks many schedules in one go, but its errors decide which one it likes best; a
simulation costs milliseconds and knows. So the K candidates that it likes best, the best of each
kind first, are carried out, and the exact robustness of the traces chooses. Where none satisfies
the formula, some others are drawn, the best attempts' actions climb the robustness
(`core.ascent`), and are nudged at random (`core.nudges`). The value alone is never climbed: that
exploits its errors.

Dimensions: K candidates, L steps, V variables, G subgoals, n state, m action, A atoms.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.ascent import Climb
from core.attempts import Attempt, Attempts, Kind, of_every_kind, tries, with_nudged
from core.candidates import Ranking, ranked
from core.controller import Controller
from core.deciding import Deciding, deciding_margin
from core.evaluation import rollout_robustness
from core.nudges import PARENTS
from core.rollout import Rollout, no_nudges, roll_out, rollout_jobs
from core.task.physics import physics_of
from core.task.protocols import Array
from core.task.task import Task

ROUNDS, ROUNDS_IN_PHYSICS = 24, 4
"""Rounds before the answer is that no plan was found."""

DRAWS = 3
"""Rounds that have new schedules, whose drawing takes longer than to carry them out."""

CLIMBING = (6, 10, 14, 18, 22)
"""Rounds before which attempts climb: each takes as long as several rounds, most need none."""

NUDGED = 0.75
"""Share of the attempts of rounds with new schedules that are nudged ones, after the first."""

MOST_ALTERNATIVES = 6


@dataclass(frozen=True, eq=False)
class Plan:
    """A schedule that was carried out once."""

    schedule: np.ndarray  # [V]
    kind: Kind
    nudges: np.ndarray  # [L, m] part of the actions that is not the controller's
    robustness: float  # of the formula on the trace [m]; -inf if the simulation broke down
    states: np.ndarray  # [L + 1, n]
    actions: np.ndarray  # [L, m]
    margins: np.ndarray  # [L + 1, A]

    @property
    def satisfied(self) -> bool:
        """Exact satisfaction of the formula by the trace."""
        return self.robustness >= 0

    @property
    def nudged(self) -> bool:
        """Whether the controller alone does not repeat the plan (see `core.nudges`)."""
        return bool(self.nudges.any())


class Effort(NamedTuple):
    """How long is searched for a plan."""

    rounds: int | None = None
    """Most rounds; the first that satisfies the formula is the last. None: as many as suit."""
    nudging: bool = True
    """Whether actions are nudged, too; else all attempts are the controller's own."""
    interrupted: Callable[[], bool] = lambda: False
    """Asked after each round whether the search shall end with what it has."""


THOROUGH = Effort()


@dataclass(frozen=True, eq=False)
class Answer:
    """What was found for a task from one initial state."""

    plan: Plan
    """The most robust one."""
    alternatives: tuple[Plan, ...]
    """The most robust satisfying plan of each other kind, the most robust first."""
    tried: int
    """Attempts that were carried out."""
    rounds: int
    """Rounds that it took."""
    seconds: float
    """Wall-clock time, compilation apart if it had been done before."""
    compile_seconds: float
    """What compiling on the way took beside, for climbs."""


CarryOut = Callable[[np.ndarray, np.ndarray], Rollout]
"""Simulates K schedules [K, V] with nudges [L, K, m]."""


def answer(
    task: Task,
    controller: Controller,
    state: Array,
    *,
    seed: int = 0,
    effort: Effort = THOROUGH,
) -> Answer:
    """The most robust plan from an initial state [n] that a bounded search finds.

    Args:
        task: the grounded task.
        controller: carries out schedules; one that knows none is tried once.
        state: where the robot stands.
        seed: of the draws.
        effort: of the search.
    """

    def rank(number: int) -> Ranking:
        key = jax.random.fold_in(jax.random.key(seed), number)
        return ranked(task.problem, controller, key, state)

    def carry_out(schedules: np.ndarray, nudges: np.ndarray) -> Rollout:
        states = jnp.broadcast_to(state, (len(schedules), *state.shape))
        return roll_out(task, controller, states, jnp.asarray(schedules), nudges)

    if controller.search is None:
        effort = effort._replace(rounds=1)
    steps = np.repeat(np.asarray(state)[None], task.padded_horizon + 1, 0)
    climb = Climb(task, controller, steps, known=0)
    return best_answer(task, rank, carry_out, climb, seed=seed, effort=effort)


def best_answer(
    task: Task,
    rank: Callable[[int], Ranking],
    carry_out: CarryOut,
    climb: Climb,
    *,
    seed: int,
    effort: Effort,
) -> Answer:
    """The most robust of the plans that are carried out.

    Args:
        task: whose formula decides.
        rank: candidates of the round of a number, from 0.
        carry_out: simulates attempts.
        climb: makes them more robust.
        seed: of the nudges.
        effort: of the search.
    """
    began, random = time.perf_counter(), np.random.default_rng(seed)
    rounds = effort.rounds or _rounds(task)
    if not effort.nudging:
        rounds = min(rounds, DRAWS)
    nearest: list[_Judged] = []  # the most robust first
    judged: list[_Judged] = []  # of the last round
    found: dict[Kind, _Judged] = {}
    number, tried, compiled = 0, 0, 0.0
    while not (found or number == rounds or (number and effort.interrupted())):
        if number < DRAWS:
            attempts = of_every_kind(rank(number), no_nudges(task, tries(task)))
        if number and effort.nudging:
            climbed: list[Attempt] = []
            if number in CLIMBING:
                compiled += climb.prepare(PARENTS)
                climbed = climb(judged[:PARENTS])
            share = NUDGED if number < DRAWS else 1
            attempts = with_nudged(random, attempts, nearest, climbed, share=share)
        tried += attempts.distinct
        rollout = carry_out(attempts.schedules, attempts.nudges)
        score, traces = rollout_robustness(task, rollout), [np.asarray(each) for each in rollout]
        best_first = np.argsort(-score, kind="stable")
        judged = [_Judged(float(score[index]), attempts, traces, index) for index in best_first]
        nearest = sorted([*nearest, *judged[:PARENTS]], key=lambda each: -each.robustness)[:PARENTS]
        for each in judged:
            if each.robustness >= 0:
                found.setdefault(each.kind, each)
        number += 1
    others = [each.plan for kind, each in found.items() if kind != nearest[0].kind]
    spent = time.perf_counter() - began - compiled
    others = tuple(others[:MOST_ALTERNATIVES])
    return Answer(nearest[0].plan, others, tried, number, spent, compiled)


def answer_jobs(task: Task, controller: Controller) -> list[Callable[[], Any]]:
    """Compilations that an answer needs, and the share of K starts that succeed with it."""
    return rollout_jobs(task, controller, tries(task))


def _rounds(task: Task) -> int:
    return ROUNDS if physics_of(task.robot) is None else ROUNDS_IN_PHYSICS


class _Judged(NamedTuple):
    """One of the attempts of a round, and how robust it was."""

    robustness: float
    attempts: Attempts
    traces: list[np.ndarray]
    """States, actions and margins, as of a `Rollout`."""
    index: int

    @property
    def kind(self) -> Kind:
        return self.attempts.kinds[self.index]

    @property
    def schedule(self) -> np.ndarray:
        return self.attempts.schedules[self.index]

    @property
    def nudges(self) -> np.ndarray:
        return self.attempts.nudges[:, self.index]

    @property
    def actions(self) -> np.ndarray:
        return self.traces[1][:, self.index]

    @property
    def deciding(self) -> Deciding | None:
        return deciding_margin(self.robustness, self.traces[2][:, self.index])

    @property
    def plan(self) -> Plan:
        states, actions, margins = (trace[:, self.index] for trace in self.traces)
        kind, schedule, nudges = self.kind, self.schedule, self.nudges
        return Plan(schedule, kind, nudges, self.robustness, states, actions, margins)
