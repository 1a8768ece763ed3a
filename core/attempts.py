"""Attempts: what a round of the search for a plan carries out.

Dimensions: K attempts, L steps, V variables, G subgoals, m action.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from core.candidates import Ranking
from core.nudges import drawn_nudges


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


class Parent(Protocol):
    """An attempt that is varied."""

    @property
    def schedule(self) -> np.ndarray:
        """[V]."""
        ...

    @property
    def kind(self) -> Kind:
        """Of the schedule."""
        ...

    @property
    def nudges(self) -> np.ndarray:
        """[L, m]."""
        ...

    @property
    def deciding_step(self) -> int | None:
        """The step that decided its robustness, if it is known."""
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
    random: np.random.Generator, attempts: Attempts, parents: Sequence[Parent], *, share: float
) -> Attempts:
    """The attempts, a share of them replaced by the parents in turn, with further nudges.

    Half of these are focused on the step that decided a parent's robustness.
    """
    steps, count, size = attempts.nudges.shape
    kept = count - int(share * count)
    dealt = [parents[number % len(parents)] for number in range(count - kept)]
    nudges = np.stack([parent.nudges for parent in dealt], 1)
    two_turns = [*(parent.deciding_step for parent in parents), *(None for _ in parents)]
    focus = [two_turns[number % len(two_turns)] for number in range(count - kept)]
    nudges = nudges + drawn_nudges(random, steps, size, focus)
    schedules = np.stack([parent.schedule for parent in dealt])
    return Attempts(
        np.concatenate([attempts.schedules[:kept], schedules]),
        attempts.kinds[:kept] + [parent.kind for parent in dealt],
        np.concatenate([attempts.nudges[:, :kept], nudges], 1),
    )
