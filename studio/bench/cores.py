"""Cores of the processor, dealt to runs that go on at the same time.

A process that keeps to a core has a pool of one thread: XLA and the linear algebra of NumPy count
the cores that they may use when they begin.
"""

import os
from collections.abc import Sequence

POOLS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that bound the pools of libraries that count before a process can say anything."""


def own_cores() -> tuple[int, ...]:
    """Numbers of the cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return tuple(sorted(os.sched_getaffinity(0)))
    return tuple(range(os.cpu_count() or 1))


def dealt(cores: Sequence[int], processes: int) -> list[tuple[int, ...]]:
    """The cores of each of some processes; none where they need not be dealt."""
    if processes == 1 or not hasattr(os, "sched_setaffinity"):
        return [()] * processes
    if processes >= len(cores):
        return [(cores[slot % len(cores)],) for slot in range(processes)]
    return [tuple(cores[slot::processes]) for slot in range(processes)]


def one_of(cores: Sequence[int]) -> tuple[int, ...]:
    """One core of a share, or of all, so that seconds of the processor compare."""
    if not hasattr(os, "sched_setaffinity"):
        return ()
    return tuple(cores or own_cores())[:1]


def keep_to(cores: Sequence[int]) -> None:
    """Keep this process to some cores, before XLA begins; to all of them if none are named."""
    if cores:
        os.sched_setaffinity(0, cores)


def bounded(cores: Sequence[int]) -> dict[str, str]:
    """Variables of the environment of a process that keeps to some cores."""
    return dict.fromkeys(POOLS, str(len(cores))) if cores else {}
