"""Runs the jobs of a matrix in local processes, those that the store lacks.

Whoever interrupts it, by Ctrl-C or by `kill -9`, loses the runs that were under way and nothing
else: started again, it goes on with those and the rest.
"""

import os
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from pathlib import Path
from queue import SimpleQueue
from typing import IO, NamedTuple

import msgspec
from filelock import FileLock, Timeout

from core.errors import UserError
from studio.bench.cores import bounded, dealt, one_of, own_cores
from studio.bench.matrix import Job
from studio.bench.order import Order
from studio.bench.store import Store

LOG_LINES = 3
"""Last lines of a log that are shown of a run that failed."""


class Outcome(NamedTuple):
    """How a process ended."""

    job: Job
    failure: str
    """Empty for a run that is now in the store."""


def run_jobs(
    store: Store, jobs: Iterable[Job], *, processes: int, told: Callable[[Outcome], None]
) -> list[Outcome]:
    """Run the jobs that the store lacks; returns those that failed.

    Args:
        store: gets a row for each.
        jobs: in the order in which they are begun.
        processes: that run at the same time, each on its share of the cores if there are several;
            a job with a budget of the processor's seconds on one core.
        told: is called as each ends.

    Raises:
        UserError: another process adds to the store, or it cannot be written.
    """
    store.open()
    failed: list[Outcome] = []
    with alone(store.folder):
        missing = (job for job in jobs if not store.finished(job.key))
        for outcome in _outcomes(store, missing, processes):
            if outcome.failure:
                failed.append(outcome)
            told(outcome)
    return failed


def _outcomes(store: Store, jobs: Iterator[Job], processes: int) -> Iterator[Outcome]:
    """Run jobs, so many at a time; those under way end with this generator."""
    running: set[Future[Outcome]] = set()
    alive: deque[subprocess.Popen[str]] = deque()
    slots: SimpleQueue[tuple[int, ...]] = SimpleQueue()
    for cores in dealt(own_cores(), processes):
        slots.put(cores)

    def run(job: Job) -> Outcome:
        cores = slots.get()
        try:
            kept = cores if job.cpu_seconds is None else one_of(cores)
            return _run(store, Order(job, processes, kept), alive)
        finally:
            slots.put(cores)

    with ThreadPoolExecutor(processes) as pool:
        try:
            for job in jobs:
                running.add(pool.submit(run, job))
                if len(running) == processes:
                    done, running = wait(running, return_when=FIRST_COMPLETED)
                    yield from (future.result() for future in done)
            while running:
                done, running = wait(running, return_when=FIRST_COMPLETED)
                yield from (future.result() for future in done)
        finally:
            for process in list(alive):
                process.kill()


def _run(store: Store, order: Order, alive: deque[subprocess.Popen[str]]) -> Outcome:
    """Run one job in a process, and wait for it."""
    job = order.job
    command = [sys.executable, "-m", "studio.bench.worker", str(store.folder)]
    with store.log(job.key).open("w", encoding="utf-8") as log:
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=log,
            stderr=subprocess.STDOUT,
            text=True,
            env=os.environ | bounded(order.cores),
            start_new_session=True,  # Ctrl-C is for the runner, which ends it
        )
        alive.append(process)
        _send(process.stdin, order)
        status = process.wait()
        alive.remove(process)
    assert process.stdin is not None
    with suppress(BrokenPipeError):  # what it has not read is written once more
        process.stdin.close()
    if status == 0 and store.finished(job.key):
        return Outcome(job, "")
    return Outcome(job, f"exit status {status}: {_last_lines(store.log(job.key))}")


def _send(pipe: IO[str] | None, order: Order) -> None:
    """Send an order; the pipe stays open, as its end ends the process."""
    assert pipe is not None
    with suppress(BrokenPipeError):  # the process has ended, and its log says why
        pipe.write(msgspec.json.encode(order).decode() + "\n")
        pipe.flush()


def _last_lines(log: Path) -> str:
    lines = log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    return " / ".join(lines[-LOG_LINES:]) or "nothing was said"


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Keep others from adding to the store; the system lets go of it however this process ends."""
    lock = FileLock(folder / "lock", blocking=False)
    try:
        lock.acquire()
    except Timeout as error:
        raise UserError(f"{folder}: another tgpo-bench adds runs to it") from error
    try:
        yield
    finally:
        lock.release()
