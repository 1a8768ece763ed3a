"""Runs the jobs of a matrix on a Ray cluster, those that the store lacks.

Each run is a task of one core in a process of its own, with a pool of one thread. Only the process
that was started here writes to the store, so the machines need no common file system; the program
must be installed on all of them.
"""

import os
from collections.abc import Callable, Iterable, Iterator
from importlib import import_module
from itertools import islice
from typing import Any

import msgspec

from core.errors import UserError
from studio.bench.matrix import Job
from studio.bench.runner import Outcome, alone
from studio.bench.store import Store

LOCAL = "local"
"""Address that begins a cluster of this machine alone."""


def run_on_cluster(
    store: Store,
    jobs: Iterable[Job],
    *,
    address: str,
    processes: int | None,
    told: Callable[[Outcome], None],
) -> list[Outcome]:
    """Run the jobs that the store lacks; returns those that failed.

    Args:
        store: gets a row for each.
        jobs: in the order in which they are handed over.
        address: of the cluster, as Ray knows it, or `local`.
        processes: runs at the same time; None for as many as the cluster has cores.
        told: is called as each ends.

    Raises:
        UserError: Ray is not installed, no such cluster, or a store that cannot be written.
    """
    ray = _connected(address)
    try:
        store.open()
        with alone(store.folder):
            most = processes or max(1, int(ray.cluster_resources().get("CPU", 1)))
            missing = (job for job in jobs if not store.finished(job.key))
            failed = []
            for outcome in _outcomes(ray, store, missing, most):
                if outcome.failure:
                    failed.append(outcome)
                told(outcome)
            return failed
    finally:
        ray.shutdown()


def _connected(address: str) -> Any:
    try:
        ray: Any = import_module("ray")
    except ImportError as error:
        raise UserError("--ray needs Ray: pip install 'tgpo-studio[cluster]'") from error
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    own = {"include_dashboard": False} if address == LOCAL else {}
    try:
        ray.init(address=address, log_to_driver=False, logging_level="ERROR", **own)
    except (ConnectionError, OSError, RuntimeError, ValueError) as error:
        first = str(error).strip().splitlines()[0]
        raise UserError(f"--ray: no cluster at {address!r}: {first}") from error
    return ray


def _outcomes(ray: Any, store: Store, jobs: Iterator[Job], most: int) -> Iterator[Outcome]:
    """Hand jobs over, so many at a time, and keep what comes back."""
    remote = ray.remote(max_calls=1, max_retries=0, num_cpus=1)(_measured)
    running: dict[Any, Job] = {}

    def hand_over(count: int) -> None:
        for job in islice(jobs, count):
            running[remote.remote(msgspec.json.encode(job))] = job

    hand_over(most)
    while running:
        (reference, *_), _ = ray.wait(list(running), num_returns=1)
        job = running.pop(reference)
        try:
            store.add(ray.get(reference))
            yield Outcome(job, "")
        except ray.exceptions.RayError as error:
            store.log(job.key).write_text(str(error), encoding="utf-8")
            yield Outcome(job, str(error).strip().splitlines()[-1])
        hand_over(1)


def _measured(text: bytes) -> dict[str, Any]:
    """The row of a job, in a process of the cluster."""
    os.environ["NPROC"] = "1"  # the size of XLA's pool of threads, read when it begins
    from core.compilation import use_disk_cache  # noqa: PLC0415
    from studio.bench.worker import measure  # noqa: PLC0415

    use_disk_cache()
    return measure(msgspec.json.decode(text, type=Job), None)
