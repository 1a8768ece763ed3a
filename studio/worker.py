"""Training in the background: one thread that consumes `core.training.train`.

The page reads `Trainer.snapshot`, an immutable value that the thread replaces after every epoch.
"""

import threading
import time
import traceback
from dataclasses import dataclass, field, replace
from enum import Enum
from queue import SimpleQueue

import jax.numpy as jnp

from core.errors import UserError
from core.networks import Parameters
from core.protocols import Array
from core.task import Task
from core.training import Progress, RunState, TrainingConfig, fresh_state, train


class Stage(Enum):
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
    diverged: int = 0
    """Simulations that broke down; their episodes have failed."""


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
    state: RunState | None = None
    """From which the training can go on; None for weights that were loaded."""
    origin: str = ""
    """Where weights that were loaded come from."""
    began_epoch: int = 0
    """Epochs that were finished when the training was last started or resumed."""
    began_seconds: float = 0.0
    """Training time at that moment [s]."""

    @property
    def running(self) -> bool:
        """Whether there is something to stop."""
        return self.stage in (Stage.COMPILING, Stage.TRAINING)

    @property
    def busy(self) -> bool:
        """Whether it runs or has halted: another training waits for its end."""
        return self.running or self.stage is Stage.PAUSED

    @property
    def trained_seconds(self) -> float:
        """What counts against the time limit: of the state that the training goes on from [s]."""
        return 0.0 if self.state is None else float(self.state.seconds)

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
    """From which it goes on."""
    pause: threading.Event = field(default_factory=threading.Event)


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
        self._begin(Training(Stage.COMPILING, task, config, time.monotonic()))

    def adopt(
        self,
        task: Task,
        config: TrainingConfig,
        parameters: Parameters,
        *,
        epoch: int,
        success: float,
        origin: str,
    ) -> None:
        """Show weights that were learnt elsewhere in place of a training's."""
        self.stop()
        loaded = Training(
            Stage.LOADED,
            task,
            config,
            epoch=epoch,
            curve=(Point(epoch, success, success),),
            parameters=parameters,
            origin=origin,
        )
        with self._lock:
            self._job, self.snapshot = None, loaded

    def stop(self) -> None:
        """Ask the training to end after the epoch that runs; compilation cannot be cut short."""
        if self._job is not None:
            self._job.stop.set()
        with self._lock:
            if self.snapshot.stage is Stage.PAUSED:
                self.snapshot = _with_best(replace(self.snapshot, stage=Stage.STOPPED))

    def pause(self) -> None:
        """Ask the training to halt after the epoch that runs."""
        if self._job is not None:
            self._job.pause.set()

    def proceed(self, config: TrainingConfig | None = None) -> None:
        """Go on with a training that has halted, with a larger budget if one is given.

        Raises:
            UserError: there is nothing to go on with.
        """
        last = self.snapshot
        if last.running or last.task is None or last.config is None or last.parameters is None:
            raise UserError("There is no training to go on with.")
        config = config or last.config
        state = last.state
        if state is None:  # loaded weights, with a fresh optimizer
            state = fresh_state(last.task, config)
            learner = state.learner._replace(parameters=last.parameters)
            state = state._replace(learner=learner, best=last.parameters)
        state = state._replace(finished=jnp.bool_(False))
        self._begin(
            replace(
                last,
                stage=Stage.COMPILING,
                config=config,
                began=time.monotonic(),
                began_epoch=int(state.epoch),
                began_seconds=float(state.seconds),
                state=state,
                curve=last.curve if last.state is not None else (),
                error="",
                origin="",
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
        curve = list(self.snapshot.curve) if job.state is not None else []
        if not job.stop.is_set():
            for progress in train(job.task, job.config, job.state):
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
                    state=progress.state,
                )
                if job.stop.is_set() or job.pause.is_set():
                    break
        stage = Stage.STOPPED if job.stop.is_set() else Stage.DONE
        if job.pause.is_set() and not job.stop.is_set():
            stage = Stage.PAUSED
        with self._lock:
            if job is self._job:
                ended = replace(self.snapshot, stage=stage)
                self.snapshot = ended if stage is Stage.PAUSED else _with_best(ended)

    def _publish(self, job: _Job, **changes) -> None:
        """Replace the snapshot, unless another training has taken its place."""
        with self._lock:
            if job is self._job:
                self.snapshot = replace(self.snapshot, **changes)


def _with_best(training: Training) -> Training:
    """With the weights of the best evaluation, if there was one."""
    state = training.state
    if state is None or float(state.best_success) < 0:
        return training
    return replace(training, parameters=state.best)


def _point(progress: Progress, curve: list[Point]) -> Point:
    if progress.evaluation is not None:
        success = progress.evaluation.success_rate
    else:
        success = curve[-1].success if curve else float("nan")
    return Point(
        progress.epoch, progress.batch_success, success, progress.batch_return, progress.diverged
    )
