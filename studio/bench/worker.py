"""One run in its own process: `python -m studio.bench.worker STORE`, an order on standard input.

The process ends with its runner, however that ends: standard input is kept open for as long as the
runner lives, and its end is the sign. A process serves one run, so that its memory is the run's.
"""

import os
import sys
import threading
import time
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import jax
import msgspec

from core.compilation import use_disk_cache
from core.controller import Controller
from core.errors import UserError
from core.methods.training import (
    Progress,
    TrainingConfig,
    best_weights,
    final_evaluation,
    train,
)
from core.task.protocols import stride_of
from core.task.task import Task
from scenes import load_task
from studio.bench.cores import keep_to, own_cores
from studio.bench.critic import critic_map, critic_samples, middle_robustness
from studio.bench.horizons import with_horizon
from studio.bench.machine import git_revision, machine, peak_memory, versions
from studio.bench.matrix import Job, changed
from studio.bench.order import Order
from studio.bench.others import OTHERS, measured
from studio.bench.store import Store
from studio.runs.config import RunConfig, make_config
from studio.runs.json_documents import plain

BEYOND = 2**19
"""Number of the random key for what is asked beyond success."""

LOST = 3
"""Exit status of a process whose runner has ended."""


def measure(job: Job, concurrent: int | None = 1) -> dict[str, Any]:
    """Train, evaluate, and return the row of a run; a job that is not allowed is `refused`.

    `concurrent` runs go on at the same time on this machine, as far as is known.
    """
    began, cpu_began = time.perf_counter(), time.process_time()
    scene = load_task(job.task)
    row: dict[str, Any] = {
        "key": job.key,
        "status": "finished",
        "robot": scene.robot,
        "horizon": scene.horizon if job.horizon is None else job.horizon,
        **{name: getattr(job, name) for name in ("task", "method", "mode", "variant", "weights")},
        "seed": job.seed,
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "revision": git_revision(),
        "versions": versions(),
        "machine": {name: str(value) for name, value in machine().items()},
        "job": msgspec.json.encode(job).decode(),
        "concurrent": concurrent,
        "cores": len(own_cores()),
    }
    try:
        row |= measured(job) if job.method in OTHERS else _trained(configuration(job), job)
    except UserError as error:
        row |= {"status": "refused", "message": str(error)}
    return row | {
        "wall_seconds": time.perf_counter() - began,
        "cpu_seconds": time.process_time() - cpu_began,
        "peak_bytes": peak_memory(),
    }


def configuration(job: Job) -> RunConfig:
    """The configuration of a job.

    Raises:
        UserError: hyper-parameters or a horizon that are not allowed.
    """
    config = make_config(
        with_horizon(load_task(job.task), job.horizon),
        mode=job.mode,
        method=job.method,
        seed=job.seed,
        epochs=job.epochs,
        time_limit=job.seconds,
        target=job.target,
        weights=job.weights,
    )
    training = config.training
    algorithm = changed(
        training.algorithm, job.changes, job.method, job.mode, f"variants.{job.variant}"
    )
    every = training.evaluate_every if job.evaluate_every is None else job.evaluate_every
    return replace(config, training=replace(training, algorithm=algorithm, evaluate_every=every))


def _trained(config: RunConfig, job: Job) -> dict[str, Any]:
    """What a training came to."""
    task, training, cpu_limit = config.build_task(), config.training, job.cpu_seconds
    curve: list[dict[str, Any]] = []
    last: Progress | None = None
    for last in train(task, training, config.first_state(task)):
        if last.evaluation is not None:
            curve.append(_point(last))
        if cpu_limit is not None and last.cpu_seconds >= cpu_limit:
            break
    if last is None:
        raise UserError("the budget ended before the first epoch")
    weights = best_weights(task, training, last.state)
    evaluation = final_evaluation(task, training, weights)
    return {
        **_beyond(task, training.controller(weights), job),
        "success_rate": evaluation.success_rate,
        "robustness_mean": plain(evaluation.robustness_mean),
        "epochs": last.epoch,
        "env_steps": last.env_steps,
        "stopped": _stopped(last, training, cpu_limit),
        "train_seconds": last.train_seconds,
        "train_cpu_seconds": last.cpu_seconds,
        "compile_seconds": last.compile_seconds,
        "curve": curve,
        "configuration": msgspec.json.encode(config.document()).decode(),
    }


def _beyond(task: Task, controller: Controller, job: Job) -> dict[str, Any]:
    """What is asked of the weights beyond their success."""
    key, found = jax.random.fold_in(jax.random.key(job.seed), BEYOND), {}
    if stride_of(task.robot) is not None:
        found["middle_robustness"] = plain(middle_robustness(task, controller, key))
    if job.critic_samples and controller.search is not None:
        found |= critic_samples(task, controller, key, job.critic_samples)
        found |= critic_map(task, controller, key)
    return found


def _stopped(last: Progress, training: TrainingConfig, cpu_limit: float | None) -> str:
    """By what a training has ended."""
    if bool(last.state.finished):
        return "target"
    if last.epoch >= training.epochs:
        return "epochs"
    used_up = cpu_limit is not None and last.cpu_seconds >= cpu_limit
    return "cpu_seconds" if used_up else "seconds"


def _point(progress: Progress) -> dict[str, Any]:
    assert progress.evaluation is not None
    return {
        "epoch": progress.epoch,
        "seconds": progress.train_seconds,
        "cpu_seconds": progress.cpu_seconds,
        "env_steps": progress.env_steps,
        "success_rate": progress.evaluation.success_rate,
        "robustness_mean": plain(progress.evaluation.robustness_mean),
    }


def _end_with_the_runner() -> None:
    sys.stdin.read()
    os._exit(LOST)


def main(folder: str) -> None:
    """Read an order, carry it out, and add its row to a store."""
    order = msgspec.json.decode(sys.stdin.readline(), type=Order)
    threading.Thread(target=_end_with_the_runner, daemon=True).start()
    keep_to(order.cores)
    use_disk_cache()
    Store(Path(folder)).add(measure(order.job, order.concurrent))


if __name__ == "__main__":
    main(sys.argv[1])
