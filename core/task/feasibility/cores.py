"""Smallest sets of holds that cannot be met together."""

from core.task.feasibility.obligations import Scope
from core.task.feasibility.search import Search

MOST_CORES = 3
"""Reasons that are told."""


def cores_of(search: Search) -> list[tuple[int, ...]]:
    """Minimal sets of holds without a solution, the first from all holds.

    The others are found with each hold of the ones before left out in turn.
    """
    everything = tuple(range(len(search.conflicts.obligations.holds)))
    cores: list[tuple[int, ...]] = []
    waiting = [everything]
    while waiting and len(cores) < MOST_CORES:
        kept = waiting.pop(0)
        if search.possible(kept):
            continue
        core = minimal(search, kept)
        if core not in cores:
            cores.append(core)
        waiting += [tuple(i for i in kept if i != left_out) for left_out in core]
    return sorted(cores, key=len)


def minimal(search: Search, kept: tuple[int, ...], scope: Scope = ()) -> tuple[int, ...]:
    """Of holds without a solution, some each of which is needed for that.

    Args:
        search: where they have no solution.
        kept: their numbers.
        scope: alternatives that are chosen.
    """
    for i in reversed(kept):
        without = tuple(j for j in kept if j != i)
        if not search.possible(without, scope=scope):
            kept = without
    return kept
