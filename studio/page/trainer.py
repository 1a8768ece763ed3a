"""Training in the background: one thread that consumes `core.methods.training.train`.

The page reads `Trainer.snapshot`, an immutable value that the thread replaces after every epoch.
"""

import threading
import time
import traceback
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from queue import SimpleQueue
from typing import Any

import jax.numpy as jnp
import numpy as np

from core.controller import Controller
from core.errors import UserError
from core.methods.training import (
    Progress,
    RunState,
    TrainingConfig,
    best_weights,
    state_from_weights,
    train,
    what_fails,
)
from core.task.task import Task
from scenes import Scene
from studio.page.worker import Worker


class Phase(Enum):
    """Where a training stands."""

    IDLE = "idle"
    LOADED = "loaded"
    COMPILING = "compiling"
    TRAINING = "training"
    PAUSED = "paused"
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
    batch_return: float = 0.0
    """Mean reward per step."""
    seconds: float = 0.0
    """Training time at its end [s]."""
    diverged: int = 0
    """Simulations that diverged; their episodes count as failed."""


@dataclass(frozen=True, eq=False)
class Training:
    """What is known about a training at one instant."""

    phase: Phase = Phase.IDLE
    task: Task | None = None
    config: TrainingConfig | None = None
    scene: Scene | None = None
    """What the task was built from."""
    identity: object = field(default_factory=object)
    """The same for all snapshots of one training, of no other."""
    began: float = 0.0
    """`time.monotonic` when it was requested [s]."""
    epoch: int = 0
    env_steps: int = 0
    seconds: float = 0.0
    """Training time, not counting compilation [s]."""
    curve: tuple[Point, ...] = ()
    chains: np.ndarray | None = None
    """Schedules [C, V] that the search for times stands at."""
    weights: Any = None
    """After the last epoch; of the best evaluation once the training has ended."""
    error: str = ""
    state: RunState | None = None
    """From which training can continue; None for loaded weights."""
    origin: str = ""
    """Where loaded weights come from."""
    general: bool = False
    """Whether the weights are the robot's, which were trained on no scene."""
    obstacle: str = ""
    """What stands in the way, once a training has ended that never succeeded."""
    began_epoch: int = 0
    """Epochs finished when training was last started or resumed."""
    began_seconds: float = 0.0
    """Training time at that moment [s]."""

    @cached_property
    def controller(self) -> Controller | None:
        """What the weights do; None without weights."""
        if self.weights is None or self.config is None:
            return None
        return self.config.controller(self.weights)

    @property
    def running(self) -> bool:
        """Whether there is something to stop."""
        return self.phase in (Phase.COMPILING, Phase.TRAINING)

    @property
    def busy(self) -> bool:
        """Whether it runs or is paused: another training waits for its end."""
        return self.running or self.phase is Phase.PAUSED

    @property
    def trained_seconds(self) -> float:
        """Training time that counts against the limit: of the state that it continues from [s]."""
        return 0.0 if self.state is None else float(self.state.seconds)

    @cached_property
    def pace_change(self) -> int | None:
        """Epoch after which epochs take longer, None if they do not."""
        if self.task is None or self.config is None:
            return None
        return self.config.learner(self.task).pace_change

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
    state: RunState | None = None
    """From which it continues."""
    pause: threading.Event = field(default_factory=threading.Event)


class Trainer:
    """One training at a time; a new one replaces the old."""

    def __init__(self) -> None:
        self.snapshot = Training()
        self._job: _Job | None = None
        self._jobs: SimpleQueue[_Job | None] = SimpleQueue()
        self._lock = threading.Lock()
        self._worker = Worker("trainer", self._work, self._end)

    def start(
        self,
        task: Task,
        config: TrainingConfig,
        scene: Scene | None = None,
        state: RunState | None = None,
    ) -> None:
        """Train on a task, from scratch or a state; what runs now is stopped and forgotten."""
        self.stop()
        now = time.monotonic()
        self._begin(Training(Phase.COMPILING, task, config, scene, began=now, state=state))

    def adopt(
        self,
        task: Task,
        config: TrainingConfig,
        weights: Any,
        scene: Scene | None = None,
        *,
        epoch: int,
        success: float,
        origin: str,
    ) -> None:
        """Show loaded weights instead of a training's."""
        self.stop()
        loaded = Training(
            Phase.LOADED,
            task,
            config,
            scene,
            epoch=epoch,
            curve=(Point(epoch, success, success),),
            weights=weights,
            origin=origin,
        )
        with self._lock:
            self._job, self.snapshot = None, loaded

    def stop(self) -> None:
        """Ask the training to end after the epoch that runs; compilation cannot be cut short."""
        with self._lock:
            if self._job is not None:
                self._job.stop.set()
            if self.snapshot.phase is Phase.PAUSED:
                self.snapshot = _with_best(replace(self.snapshot, phase=Phase.STOPPED))

    def pause(self) -> None:
        """Ask the training to pause after the current epoch."""
        if self._job is not None:
            self._job.pause.set()

    def proceed(self, config: TrainingConfig | None = None) -> None:
        """Continue a training that was paused or has ended, with a larger budget if given.

        Raises:
            UserError: there is nothing to continue.
        """
        last = self.snapshot
        if last.running or last.task is None or last.config is None or last.weights is None:
            raise UserError("There is no training to go on with.")
        config = config or last.config
        state = last.state
        if state is None:  # loaded weights, with a fresh optimizer
            state = state_from_weights(last.task, config, last.weights)
        state = state._replace(finished=jnp.bool_(False))
        self._begin(
            replace(
                last,
                phase=Phase.COMPILING,
                config=config,
                began=time.monotonic(),
                began_epoch=int(state.epoch),
                began_seconds=float(state.seconds),
                state=state,
                curve=last.curve if last.state is not None else (),
                error="",
                origin="",
                obstacle="",
            )
        )

    def _begin(self, training: Training) -> None:
        assert training.task is not None and training.config is not None
        job = _Job(training.task, training.config, threading.Event(), training.state)
        with self._lock:
            self._job, self.snapshot = job, training
        self._jobs.put(job)

    def forget(self) -> None:
        """Stop, and drop what was learnt."""
        self.stop()
        with self._lock:
            self._job = None
            self.snapshot = Training()

    def close(self) -> bool:
        """Stop and end the thread; returns whether it has ended (not while it compiles)."""
        return self._worker.close()

    def _end(self) -> None:
        self.stop()
        self._jobs.put(None)

    def _work(self) -> None:
        while (job := self._jobs.get()) is not None:
            try:
                self._train(job)
            except UserError as error:
                self._publish(job, phase=Phase.FAILED, error=str(error))
            except Exception as error:  # noqa: BLE001 - the page shows it and lives on
                traceback.print_exc()
                self._publish(job, phase=Phase.FAILED, error=f"{type(error).__name__}: {error}")

    def _train(self, job: _Job) -> None:
        curve = list(self.snapshot.curve) if job.state is not None else []
        if not job.stop.is_set():
            for progress in train(job.task, job.config, job.state):
                curve.append(_point(progress, curve))
                self._publish(
                    job,
                    phase=Phase.TRAINING,
                    epoch=progress.epoch,
                    env_steps=progress.env_steps,
                    seconds=progress.train_seconds,
                    curve=tuple(curve),
                    weights=progress.weights,
                    chains=progress.schedules,
                    state=progress.state,
                )
                if job.stop.is_set() or job.pause.is_set():
                    break
        obstacle = "" if job.stop.is_set() or job.pause.is_set() else _obstacle(job, self.snapshot)
        with self._lock:
            phase = Phase.PAUSED if job.pause.is_set() else Phase.DONE
            phase = Phase.STOPPED if job.stop.is_set() else phase
            if job is self._job:
                ended = replace(self.snapshot, phase=phase, obstacle=obstacle)
                self.snapshot = ended if phase is Phase.PAUSED else _with_best(ended)

    def _publish(self, job: _Job, **changes) -> None:
        """Replace the snapshot, unless another training has taken its place."""
        with self._lock:
            if job is self._job:
                self.snapshot = replace(self.snapshot, **changes)


def _obstacle(job: _Job, training: Training) -> str:
    """The task that fails most often, where a training has never succeeded."""
    state = training.state
    if training.task is not job.task or state is None or float(state.best_success) > 0:
        return ""
    if float(state.best_success) < 0 and any(point.batch_success for point in training.curve):
        return ""  # no evaluation yet, but some episodes have succeeded
    count = job.config.learner(job.task).evaluation_states
    weights = best_weights(job.task, job.config, state)
    return what_fails(job.task, job.config, weights, count=count)


def _with_best(training: Training) -> Training:
    """With the weights of the best evaluation, if there was one."""
    state = training.state
    if state is None or float(state.best_success) < 0:
        return training
    return replace(training, weights=state.best)


def _point(progress: Progress, curve: list[Point]) -> Point:
    if progress.evaluation is not None:
        success = progress.evaluation.success_rate
    else:
        success = curve[-1].success if curve else float("nan")
    return Point(
        progress.epoch,
        progress.batch_success,
        success,
        progress.batch_return,
        progress.train_seconds,
        progress.diverged,
    )
