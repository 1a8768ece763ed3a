"""Attempts: what a round of the search for a plan carries out.

Dimensions: K attempts, L steps, V variables, G subgoals, m action.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from core.candidates import Ranking
from core.deciding import Deciding
from core.nudges import drawn_nudges
from core.task.physics import physics_of
from core.task.task import Task

TRIED, TRIED_IN_PHYSICS = 64, 8
"""K, schedules that are carried out in a round, by the robot's own `step` or in true physics."""


def tries(task: Task) -> int:
    """K for a task's robot: rollouts in the one program that answers and samples share."""
    return TRIED if physics_of(task.robot) is None else TRIED_IN_PHYSICS


class Kind(NamedTuple):
    """What tells plans apart that differ in more than their times."""

    order: tuple[int, ...]
    """Indices of the subgoals in order of start; those of branches not chosen are missing."""


class Attempts(NamedTuple):
    """Schedules, and what is added to the controller's actions while they are carried out."""

    schedules: np.ndarray  # [K, V]
    kinds: list[Kind]  # [K]
    nudges: np.ndarray  # [L, K, m]

    @property
    def distinct(self) -> int:
        """How many differ."""
        own = ~self.nudges.any((0, 2))
        return len(np.unique(self.schedules[own], axis=0)) + int((~own).sum())


class Attempt(NamedTuple):
    """One of them."""

    schedule: np.ndarray  # [V]
    kind: Kind
    nudges: np.ndarray  # [L, m]


class Scheduled(Protocol):
    """Carries out a schedule."""

    @property
    def schedule(self) -> np.ndarray:
        """[V]."""
        ...

    @property
    def kind(self) -> Kind:
        """Of the schedule."""
        ...


class Parent(Scheduled, Protocol):
    """An attempt that is varied."""

    @property
    def nudges(self) -> np.ndarray:
        """[L, m]."""
        ...

    @property
    def deciding(self) -> Deciding | None:
        """The margin that decided its robustness, if it is known."""
        ...


def of_every_kind(ranking: Ranking, nudges: np.ndarray) -> Attempts:
    """K candidates: the best of each kind in turn, then the second best of each, and so on.

    Half of them are the best whatever their kind. Repeats fill up what is missing.

    Args:
        ranking: the candidates.
        nudges: of the attempts [L, K, m].
    """
    orders, schedules = np.asarray(ranking.orders), np.asarray(ranking.schedules)
    count = nudges.shape[1]
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
    return Attempts(schedules[chosen], [kinds[index] for index in chosen], nudges)


def with_nudged(
    random: np.random.Generator,
    attempts: Attempts,
    parents: Sequence[Parent],
    climbed: Sequence[Attempt],
    *,
    share: float,
) -> Attempts:
    """The attempts, a share of them replaced: by climbed ones, and by nudged ones.

    The nudged ones are the parents in turn with further nudges, half of which are focused on the
    step that decided a parent's robustness.
    """
    steps, count, size = attempts.nudges.shape
    kept = count - int(share * count)
    varied = count - kept - len(climbed)
    dealt = [parents[number % len(parents)] for number in range(varied)]
    decided = [parent.deciding for parent in parents]
    middles = [None if each is None else each.step for each in decided]
    two_turns = [*middles, *(None for _ in parents)]
    focus = [two_turns[number % len(two_turns)] for number in range(varied)]
    nudges = np.stack([each.nudges for each in (*climbed, *dealt)], 1)
    nudges[:, len(climbed) :] += drawn_nudges(random, steps, size, focus)
    schedules = np.stack([each.schedule for each in (*climbed, *dealt)])
    return Attempts(
        np.concatenate([attempts.schedules[:kept], schedules]),
        attempts.kinds[:kept] + [each.kind for each in (*climbed, *dealt)],
        np.concatenate([attempts.nudges[:, :kept], nudges], 1),
    )
