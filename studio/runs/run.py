"""Runs: a directory with everything about one training, from which it can be resumed.

    config.json       the configuration: scene, formula, mode, method, seed, budget, all
                      hyper-parameters (only the budget changes, when a run is resumed)
    metrics.jsonl     one line per epoch
    tensorboard/      the same curves as TensorBoard events
    checkpoints/      the last two states of the training
    bundle/           the best policy (see `studio.runs.bundle`)
    summary.json      the result
    lock, lock.json   held by the process that writes the run

A run that was stopped or killed can be resumed from its last checkpoint and ends with exactly the
result of an uninterrupted run.
"""

import json
import math
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec

from core.checkpoint import load_checkpoint, require_finite, save_checkpoint, write_atomically
from core.evaluation import Evaluation
from core.methods.training import (
    Progress,
    RunState,
    best_weights,
    final_evaluation,
    fresh_state,
)
from core.task.task import Task
from studio.runs.bundle import Policy, save_bundle
from studio.runs.config import FORMAT, RunConfig, RunError, read_config, with_budget
from studio.runs.events import EventLog
from studio.runs.json_documents import plain, write_document
from studio.runs.lock import FILES, RunLock

CHECKPOINT_SECONDS = 5.0
"""Maximum training time between checkpoints, unless one epoch takes longer [s]."""


def trained_policy(config: RunConfig, weights: Any, evaluation: Evaluation, epochs: int) -> Policy:
    """The policy that a run has learnt in so many epochs, with what was measured of it."""
    return Policy(
        config.scene,
        config.mode,
        config.method,
        config.training.seed,
        config.training.algorithm,
        weights,
        evaluation.success_rate,
        evaluation.robustness_mean,
        epochs,
    )


def default_folder(parent: Path, config: RunConfig) -> Path:
    """Make a fresh folder `<task>-<method>-<seed>[-N]`."""
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", config.name).strip("-.") or "task"
    stem = f"{name}-{config.method}-{config.training.seed}"
    for number in range(1, 10_000):
        folder = parent / (stem if number == 1 else f"{stem}-{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise RunError(f"{folder}: cannot be made: {error.strerror}") from error
        return folder
    raise RunError(f"{parent}: too many runs named {stem}; choose --out")


@contextmanager
def _locked(folder: Path) -> Iterator[RunLock]:
    """The lock of a run that is being opened; released if that fails."""
    lock = RunLock(folder)
    try:
        yield lock
    except BaseException:
        lock.release()
        raise


class Run:
    """A run directory, open for writing; close it, or use it in a `with` statement."""

    def __init__(
        self, folder: Path, config: RunConfig, task: Task, state: RunState | None, lock: RunLock
    ):
        self._lock = lock
        self.folder = folder
        self.config = config
        self.task = task
        self.state = state
        """The last state with finite weights; None before the first epoch."""
        self.compile_seconds = 0.0
        self.notes: tuple[str, ...] = ()
        """What the user should know about how the run was opened."""
        self._saved_epoch = self.epochs
        self._saved_at = -math.inf
        self._events = EventLog(folder / "tensorboard", self._saved_epoch)

    @property
    def epochs(self) -> int:
        """Epochs finished."""
        return 0 if self.state is None else int(self.state.epoch)

    @classmethod
    def create(cls, folder: Path, config: RunConfig, task: Task | None = None) -> "Run":
        """Start a run in a folder that does not exist or is empty.

        Raises:
            RunError: the folder is not empty, cannot be made, or another process writes there.
            UserError: the task cannot be built.
        """
        task = config.build_task() if task is None else task
        try:
            if folder.exists() and any(map(_is_foreign, folder.iterdir())):
                raise RunError(
                    f"{folder}: exists and is not empty; choose another --out, or use "
                    f"--resume {folder}"
                )
            folder.mkdir(parents=True, exist_ok=True)
            with _locked(folder) as lock:
                write_document(folder / "config.json", config.document())
                return cls(folder, config, task, None, lock)
        except OSError as error:
            raise RunError(f"{folder}: cannot be made: {error.strerror}") from error

    @classmethod
    def resume(cls, folder: Path, **budget: Any) -> "Run":
        """Open a run to continue it, with another budget if given.

        Metrics of epochs after the last checkpoint are dropped: they are trained again.

        Raises:
            UserError: not a run, one of another version, one that another process writes, or
                checkpoints that cannot be read.
        """
        read_config(folder)  # what is not a run gets no lock
        try:
            with _locked(folder) as lock:
                return cls._resumed(folder, budget, lock)
        except OSError as error:
            raise RunError(f"{folder}: cannot be written: {error.strerror}") from error

    @classmethod
    def _resumed(cls, folder: Path, budget: dict[str, Any], lock: RunLock) -> "Run":
        config = read_config(folder)
        training = with_budget(config.training, **budget)
        config = replace(config, training=training)
        task = config.build_task(force=True)
        found = load_checkpoint(folder / "checkpoints", fresh_state(task, training))
        state, notes = None, ("no checkpoint yet: training starts from the beginning",)
        if found is not None:
            reached = found.tree.best_success >= training.target
            state = found.tree._replace(finished=reached)
            notes = found.skipped
        _keep_metrics(folder / "metrics.jsonl", 0 if state is None else int(state.epoch))
        write_document(folder / "config.json", config.document())
        run = cls(folder, config, task, state, lock)
        run.notes = notes
        return run

    def record(self, progress: Progress) -> dict[str, Any]:
        """Record an epoch; returns the line of metrics.jsonl.

        Raises:
            DivergedError: the weights are no longer finite; the epoch is not saved.
            UserError: the disk is full; the last checkpoint stays.
        """
        where = f"the training has diverged in epoch {progress.epoch} (try another seed)"
        require_finite(progress.weights, where)
        metrics = report(progress)
        try:
            with (self.folder / "metrics.jsonl").open("a", encoding="utf-8") as file:
                file.write(json.dumps(metrics, allow_nan=False) + "\n")
            self._events.write(metrics)
        except OSError as error:
            raise RunError(f"{self.folder}: cannot be written: {error.strerror}") from error
        self.state = progress.state
        self.compile_seconds = progress.compile_seconds
        if time.monotonic() - self._saved_at >= CHECKPOINT_SECONDS:
            self.checkpoint()
        return metrics

    def checkpoint(self) -> None:
        """Write the current state, unless it is already written."""
        if self.epochs > self._saved_epoch:
            save_checkpoint(self.folder / "checkpoints", self.state, self.epochs)
            self._saved_epoch = self.epochs
        self._saved_at = time.monotonic()

    def finish(self, stopped: str) -> dict[str, Any]:
        """Write the last checkpoint, evaluate the best policy and write bundle and summary.

        Args:
            stopped: why the training stopped, for the summary.

        Raises:
            RunError: no epoch was finished.
        """
        if self.state is None:
            raise RunError(f"{self.folder}: no epoch was finished, so there is no policy to save")
        self.checkpoint()
        weights = best_weights(self.task, self.config.training, self.state)
        evaluation = final_evaluation(self.task, self.config.training, weights)
        policy = trained_policy(self.config, weights, evaluation, self.epochs)
        save_bundle(policy, self.folder / "bundle")
        summary = plain(self._summary(evaluation))
        kept = {"format": FORMAT, **summary, "stopped": stopped}
        write_document(self.folder / "summary.json", kept)
        return summary

    def _summary(self, evaluation: Evaluation) -> dict[str, Any]:
        config = self.config
        steps = config.training.learner(self.task).steps_per_epoch
        return {
            "task": config.name,
            "method": config.method,
            "mode": config.mode,
            "seed": config.training.seed,
            "success_rate": evaluation.success_rate,
            "robustness_mean": evaluation.robustness_mean,
            "between_rate": evaluation.between_rate,
            "epochs": self.epochs,
            "env_steps": self.epochs * steps,
            "train_seconds": 0.0 if self.state is None else round(float(self.state.seconds), 3),
            "compile_seconds": round(self.compile_seconds, 3),
            "out": str(self.folder),
        }

    def close(self) -> None:
        """Close the event file (a full disk costs only its last points); let others write."""
        with suppress(OSError):
            self._events.close()
        self._lock.release()

    def __enter__(self) -> "Run":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def report(progress: Progress) -> dict[str, Any]:
    """The line of an epoch, as JSON values."""
    evaluation = progress.evaluation
    return plain(
        {
            "epoch": progress.epoch,
            "env_steps": progress.env_steps,
            "train_seconds": round(progress.train_seconds, 3),
            "compile_seconds": round(progress.compile_seconds, 3),
            "batch_success": progress.batch_success,
            "batch_return": progress.batch_return,
            "diverged": progress.diverged,
            "success_rate": None if evaluation is None else evaluation.success_rate,
            "robustness_mean": None if evaluation is None else evaluation.robustness_mean,
        }
    )


def _is_foreign(path: Path) -> bool:
    """Whether a file is none that a run leaves that was killed before it began."""
    leftover = re.fullmatch(r"\.(config|lock)\.json\..*\.tmp", path.name)
    return path.name not in FILES and leftover is None


class _Line(msgspec.Struct):
    """A line of metrics.jsonl, as far as it is read again."""

    epoch: int


def _keep_metrics(path: Path, epochs: int) -> None:
    """Drop the lines of later epochs, and a last line that was cut off."""
    if not path.exists():
        return
    kept = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            epoch = msgspec.json.decode(line, type=_Line).epoch
        except (msgspec.DecodeError, RecursionError):
            continue
        if epoch <= epochs:
            kept.append(line + "\n")
    write_atomically(path, "".join(kept).encode())
