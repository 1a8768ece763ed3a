"""Training in the background: one thread that consumes `core.training.train`.

The page reads `Trainer.snapshot`, an immutable value that the thread replaces after every epoch.
"""

import threading
import time
import traceback
from dataclasses import dataclass, replace
from enum import Enum
from queue import SimpleQueue

from core.errors import UserError
from core.networks import Parameters
from core.protocols import Array
from core.task import Task
from core.training import Progress, TrainingConfig, train


class Stage(Enum):
    """Where a training stands."""

    IDLE = "idle"
    COMPILING = "compiling"
    TRAINING = "training"
    DONE = "done"
    STOPPED = "stopped"
    FAILED = "failed"


@dataclass(frozen=True)
class Point:
    """One epoch of the learning curve; success rates in [0, 1]."""

    epoch: int
    batch_success: float
    success: float
    """Of the last evaluation so far, NaN before the first."""


@dataclass(frozen=True, eq=False)
class Training:
    """What is known about a training at one instant."""

    stage: Stage = Stage.IDLE
    task: Task | None = None
    config: TrainingConfig | None = None
    began: float = 0.0
    """`time.monotonic` at which it was asked for [s]."""
    epoch: int = 0
    env_steps: int = 0
    seconds: float = 0.0
    """Spent in training, compilation apart."""
    curve: tuple[Point, ...] = ()
    chains: Array | None = None
    """Schedules [C, V] at which the Metropolis-Hastings chains stand."""
    parameters: Parameters | None = None
    """Weights after the last epoch; of the best evaluation once the training has ended."""
    error: str = ""

    @property
    def running(self) -> bool:
        """Whether there is something to stop."""
        return self.stage in (Stage.COMPILING, Stage.TRAINING)

    @property
    def success(self) -> float | None:
        """Success rate of the last evaluation, None before the first."""
        rate = self.curve[-1].success if self.curve else float("nan")
        return None if rate != rate else rate  # noqa: PLR0124


@dataclass(frozen=True, eq=False)
class _Job:
    task: Task
    config: TrainingConfig
    stop: threading.Event


class Trainer:
    """One training at a time; a new one replaces the old."""

    def __init__(self) -> None:
        self.snapshot = Training()
        self._job: _Job | None = None
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._lock = threading.Lock()
        self._thread = threading.Thread(target=self._work, name="trainer", daemon=True)
        self._thread.start()

    def start(self, task: Task, config: TrainingConfig) -> None:
        """Train on a task from scratch; what runs now is stopped and forgotten."""
        self.stop()
        job = _Job(task, config, threading.Event())
        with self._lock:
            self._job = job
            self.snapshot = Training(Stage.COMPILING, task, config, time.monotonic())
        self._jobs.put(job)

    def stop(self) -> None:
        """Ask the training to end after the epoch that runs; compilation cannot be cut short."""
        if self._job is not None:
            self._job.stop.set()

    def forget(self) -> None:
        """Stop, and drop what was learnt."""
        self.stop()
        with self._lock:
            self._job = None
            self.snapshot = Training()

    def close(self) -> bool:
        """Stop and end the thread; whether it has ended, as it does not while it compiles."""
        self.stop()
        self._jobs.put(None)
        self._thread.join(timeout=3)
        return not self._thread.is_alive()

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                self._train(job)
            except UserError as error:
                self._publish(job, stage=Stage.FAILED, error=str(error))
            except Exception as error:  # noqa: BLE001 - the page shows it and lives on
                traceback.print_exc()
                self._publish(job, stage=Stage.FAILED, error=f"{type(error).__name__}: {error}")

    def _train(self, job: _Job) -> None:
        curve: list[Point] = []
        progress = None
        if not job.stop.is_set():
            for progress in train(job.task, job.config):
                curve.append(_point(progress, curve))
                self._publish(
                    job,
                    stage=Stage.TRAINING,
                    epoch=progress.epoch,
                    env_steps=progress.env_steps,
                    seconds=progress.train_seconds,
                    curve=tuple(curve),
                    parameters=progress.parameters,
                    chains=progress.state.learner.chains,
                )
                if job.stop.is_set():
                    break
        if progress is not None and float(progress.state.best_success) >= 0:
            self._publish(job, parameters=progress.state.best)
        stopped = job.stop.is_set()
        self._publish(job, stage=Stage.STOPPED if stopped else Stage.DONE)

    def _publish(self, job: _Job, **changes) -> None:
        """Replace the snapshot, unless another training has taken its place."""
        with self._lock:
            if job is self._job:
                self.snapshot = replace(self.snapshot, **changes)


def _point(progress: Progress, curve: list[Point]) -> Point:
    if progress.evaluation is not None:
        success = progress.evaluation.success_rate
    else:
        success = curve[-1].success if curve else float("nan")
    return Point(progress.epoch, progress.batch_success, success)
