"""Inputs given to a function one by one: what it refuses, what breaks it, its time and memory."""

import contextlib
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from core.errors import UserError
from tests.tools.attack.table import Row

HANG = 2.0
"""Longest answer [s of processor time: the machine may be busy with other things]."""

MOST_GROWTH = 300.0
"""Largest growth of the process at its peak [MB]."""

_GIVEN_UP = 30.0
"""An answer that takes longer by the clock is interrupted [s]."""


class Hang(BaseException):
    """An answer that was interrupted."""


def tried(
    part: str,
    what: str,
    inputs: Iterable[Any],
    answer: Callable[[Any], object],
    *,
    count: int,
    seconds: float,
    slowest_allowed: float = HANG,
) -> Row:
    """Answer at most `count` inputs in at most `seconds`; failures are described on stderr."""
    began, number, refused, failures, slowest = time.monotonic(), 0, 0, 0, 0.0
    before = _peak_mb(reset=True)
    for each in inputs:
        if number == count or time.monotonic() - began > seconds:
            break
        number += 1
        took, was_refused, problem = _answered(answer, each)
        if took > slowest_allowed and not problem:  # a program is compiled once
            took, was_refused, problem = _answered(answer, each)
        refused += was_refused
        slowest = max(slowest, took)
        if took > slowest_allowed:
            problem = problem or f"took {took:.1f} s"
        if problem:
            failures += 1
            print(f"{part}, {what}: {repr(each)[:400]}\n{problem}", file=sys.stderr)
    growth = _peak_mb() - before
    if growth > MOST_GROWTH:
        failures += 1
        print(f"{part}, {what}: grew by {growth:.0f} MB", file=sys.stderr)
    return Row(part, what, number, refused, failures, slowest, growth)


def _answered(answer: Callable[[Any], object], given: Any) -> tuple[float, bool, str]:
    """Seconds of processor time that an answer took, whether it was a refusal, and what broke."""
    start, refused, problem = time.process_time(), False, ""
    try:
        with _interrupted_after(_GIVEN_UP):
            answer(given)
    except UserError:
        refused = True
    except (Exception, Hang):
        problem = traceback.format_exc(limit=-3)
    return time.process_time() - start, refused, problem


@contextmanager
def _interrupted_after(seconds: float) -> Iterator[None]:
    def interrupt(*_: object) -> None:
        raise Hang(f"no answer within {seconds} s")

    before = signal.signal(signal.SIGALRM, interrupt)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _peak_mb(*, reset: bool = False) -> float:
    """Largest resident size of this process since the last reset, where Linux tells it [MB]."""
    try:
        if reset:
            Path("/proc/self/clear_refs").write_text("5")
    except OSError:
        pass
    with contextlib.suppress(OSError, StopIteration):
        lines = Path("/proc/self/status").read_text().splitlines()
        return int(next(x for x in lines if x.startswith("VmHWM")).split()[1]) / 1000
    return 0.0
