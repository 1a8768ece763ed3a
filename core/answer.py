"""An answer before training: schedules that the critic likes are simulated, the best is kept.

The critic ranks many schedules in one go, but its errors decide which one it likes best; a
simulation costs milliseconds and knows. So the K candidates that it likes best, the best of each
kind first, are carried out, and the exact robustness of the traces chooses. Where none satisfies
the formula, others are drawn. The value alone is never climbed: that exploits its errors.

Dimensions: K candidates, L steps, V variables, G subgoals, n state, m action, A atoms.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.candidates import Ranking, ranked
from core.controller import Controller
from core.evaluation import rollout_robustness
from core.rollout import Rollout, roll_out, rollout_jobs
from core.task.physics import physics_of
from core.task.protocols import Array
from core.task.task import Task

TRIED, TRIED_IN_PHYSICS = 64, 8
"""K, schedules that are carried out in a round, by the robot's own `step` or in true physics."""

ROUNDS = 4
"""Rounds before the answer is that no plan was found."""

MOST_ALTERNATIVES = 6


class Kind(NamedTuple):
    """What tells plans apart that differ in more than their times."""

    order: tuple[int, ...]
    """Indices of the subgoals in order of start; those of branches not chosen are missing."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A schedule that was carried out once."""

    schedule: np.ndarray  # [V]
    kind: Kind
    robustness: float  # of the formula on the trace [m]; -inf if the simulation broke down
    states: np.ndarray  # [L + 1, n]
    actions: np.ndarray  # [L, m]
    margins: np.ndarray  # [L + 1, A]

    @property
    def satisfied(self) -> bool:
        """Exact satisfaction of the formula by the trace."""
        return self.robustness >= 0


@dataclass(frozen=True, eq=False)
class Answer:
    """What was found for a task from one initial state."""

    plan: Plan
    """The most robust one."""
    alternatives: tuple[Plan, ...]
    """The most robust satisfying plan of each other kind, the most robust first."""
    tried: int
    """Schedules carried out."""
    seconds: float
    """Wall-clock time, compilation apart if it had been done before."""


def answer(
    task: Task, controller: Controller, state: Array, *, seed: int = 0, rounds: int = ROUNDS
) -> Answer:
    """The most robust plan from an initial state [n] that a bounded search finds.

    Args:
        task: the grounded task.
        controller: carries out schedules; one that knows none is tried once.
        state: where the robot stands.
        seed: of the draws.
        rounds: most rounds; the first that satisfies the formula is the last.
    """

    def rank(number: int) -> Ranking:
        key = jax.random.fold_in(jax.random.key(seed), number)
        return ranked(task.problem, controller, key, state)

    def carry_out(schedules: np.ndarray) -> Rollout:
        states = jnp.broadcast_to(state, (len(schedules), *state.shape))
        return roll_out(task, controller, states, jnp.asarray(schedules))

    return best_answer(task, rank, carry_out, rounds=1 if controller.search is None else rounds)


def best_answer(
    task: Task,
    rank: Callable[[int], Ranking],
    carry_out: Callable[[np.ndarray], Rollout],
    *,
    rounds: int,
) -> Answer:
    """The most robust of the plans that are carried out.

    Args:
        task: whose formula decides.
        rank: candidates of the round of a number, from 0.
        carry_out: simulates K schedules [K, V].
        rounds: most rounds; the first that satisfies the formula is the last.
    """
    began, best, tried = time.perf_counter(), None, 0
    found: dict[Kind, Plan] = {}
    for number in range(rounds):
        ranking = rank(number)
        orders, schedules = np.asarray(ranking.orders), np.asarray(ranking.schedules)
        chosen = _of_every_kind(orders, schedules, tries(task))
        rollout = carry_out(chosen.schedules)
        score = rollout_robustness(task, rollout)
        tried += len(np.unique(chosen.schedules, axis=0))
        for index in np.argsort(-score, kind="stable"):
            kind = chosen.kinds[index]
            if best is None or score[index] > best.robustness:
                best = _plan(chosen, rollout, score, index)
            if score[index] >= 0 and (kind not in found or score[index] > found[kind].robustness):
                found[kind] = _plan(chosen, rollout, score, index)
        if best is not None and best.satisfied:
            break
    assert best is not None
    others = [plan for kind, plan in found.items() if kind != best.kind]
    others.sort(key=lambda plan: -plan.robustness)
    spent = time.perf_counter() - began
    return Answer(best, tuple(others[:MOST_ALTERNATIVES]), tried, spent)


def answer_jobs(task: Task, controller: Controller) -> list[Callable[[], Any]]:
    """Compilations that an answer needs, and the share of K starts that succeed with it."""
    return rollout_jobs(task, controller, tries(task))


def tries(task: Task) -> int:
    """K for a task's robot: rollouts in the one program that answers and samples share."""
    return TRIED if physics_of(task.robot) is None else TRIED_IN_PHYSICS


class _Chosen(NamedTuple):
    schedules: np.ndarray  # [K, V]
    kinds: list[Kind]  # [K]


def _of_every_kind(orders: np.ndarray, schedules: np.ndarray, count: int) -> _Chosen:
    """K candidates: the best of each kind in turn, then the second best of each, and so on.

    Half of them are the best whatever their kind. Repeats fill up what is missing.
    """
    _, first = np.unique(schedules, axis=0, return_index=True)
    distinct = np.sort(first)
    kinds = [Kind(tuple(int(i) for i in row[row >= 0])) for row in orders]
    rank: dict[Kind, int] = {}
    turns = []
    for index in distinct:
        turns.append(rank.setdefault(kinds[index], 0))
        rank[kinds[index]] += 1
    half = distinct[: count // 2]
    dealt = distinct[np.argsort(turns, kind="stable")]
    rest = dealt[~np.isin(dealt, half)][: count - len(half)]
    chosen = np.resize(np.concatenate([half, rest]), count)
    return _Chosen(schedules[chosen], [kinds[index] for index in chosen])


def _plan(chosen: _Chosen, rollout: Rollout, score: np.ndarray, index: int) -> Plan:
    states, actions, margins = (np.asarray(trace)[:, index] for trace in rollout)
    kind, schedule = chosen.kinds[index], chosen.schedules[index]
    return Plan(schedule, kind, float(score[index]), states, actions, margins)
