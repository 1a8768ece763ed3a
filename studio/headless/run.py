"""Runs: a directory that holds everything about one training, and from which it can go on.

    config.json       what was asked for: scene, formula, mode, method, seed, budget, all
                      hyper-parameters (never changes, but for the budget when a run is resumed)
    metrics.jsonl     one line an epoch
    tensorboard/      the same curves as TensorBoard events
    checkpoints/      the last two states of the training
    bundle/           the best policy (see `studio.files.bundle`)
    summary.json      what came out

A run that was stopped or killed goes on from its last checkpoint and ends with exactly what an
uninterrupted run gives.
"""

import json
import math
import re
import time
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from core.checkpoint import load_checkpoint, require_finite, save_checkpoint, write_atomically
from core.evaluation import Evaluation
from core.networks import Parameters
from core.task import Task
from core.training import Progress, RunState, final_evaluation, fresh_state
from studio.files.bundle import Policy, save_bundle
from studio.files.json_documents import plain, write_document
from studio.headless.config import FORMAT, RunConfig, RunError, read_config, with_budget
from studio.headless.events import EventLog

CHECKPOINT_SECONDS = 5.0
"""Training time between checkpoints at most, unless one epoch takes longer [s]."""


def best_parameters(state: RunState) -> Parameters:
    """Weights of the best evaluation; the latest ones before the first evaluation."""
    return state.best if float(state.best_success) >= 0 else state.learner.parameters


def default_folder(parent: Path, config: RunConfig) -> Path:
    """Make a fresh folder `<task>-<method>-<seed>[-N]`."""
    name = re.sub(r"[^A-Za-z0-9._-]+", "-", config.scene.name).strip("-.") or "task"
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
    raise RunError(f"{parent}: too many runs named {stem}; give another --out")


class Run:
    """A run directory, open for writing; close it, or use it in a `with` statement."""

    def __init__(self, folder: Path, config: RunConfig, task: Task, state: RunState | None):
        self.folder = folder
        self.config = config
        self.task = task
        self.state = state
        """The last state with finite weights; None before the first epoch."""
        self.compile_seconds = 0.0
        self.notes: tuple[str, ...] = ()
        """What a person should know about how the run was opened."""
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
            RunError: the folder holds something, or cannot be made.
            UserError: the task cannot be built.
        """
        task = config.build_task() if task is None else task
        try:
            if folder.exists() and any(folder.iterdir()):
                raise RunError(
                    f"{folder}: exists and is not empty; give another --out, or go on with "
                    f"--resume {folder}"
                )
            folder.mkdir(parents=True, exist_ok=True)
            write_document(folder / "config.json", config.document())
            return cls(folder, config, task, None)
        except OSError as error:
            raise RunError(f"{folder}: cannot be made: {error.strerror}") from error

    @classmethod
    def resume(cls, folder: Path, **budget: Any) -> "Run":
        """Open a run to go on with it, with another budget if one is given.

        Metrics of epochs after the last checkpoint are dropped: they are trained again.

        Raises:
            UserError: no run, one of another version, or checkpoints that cannot be read.
        """
        config = read_config(folder)
        training = with_budget(config.training, **budget)
        config = replace(config, training=training)
        task = config.build_task()
        found = load_checkpoint(folder / "checkpoints", fresh_state(task, training))
        state, notes = None, ("no checkpoint yet: the run starts from its beginning",)
        if found is not None:
            reached = found.tree.best_success >= training.target
            state = found.tree._replace(finished=reached)
            notes = found.skipped
        try:
            _keep_metrics(folder / "metrics.jsonl", 0 if state is None else int(state.epoch))
            write_document(folder / "config.json", config.document())
            run = cls(folder, config, task, state)
        except OSError as error:
            raise RunError(f"{folder}: cannot be written: {error.strerror}") from error
        run.notes = notes
        return run

    def record(self, progress: Progress) -> dict[str, Any]:
        """Write down an epoch; returns the line of metrics.jsonl.

        Raises:
            DivergedError: the weights are no longer finite; nothing of the epoch is kept.
            UserError: the disk is full; the last checkpoint stays.
        """
        where = f"the training has diverged in epoch {progress.epoch} (try another seed)"
        require_finite(progress.parameters, where)
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
        """Write the present state, unless it is already written."""
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
            raise RunError(f"{self.folder}: no epoch was finished, there is no policy to keep")
        self.checkpoint()
        parameters = best_parameters(self.state)
        evaluation = final_evaluation(self.task, self.config.training, parameters)
        save_bundle(self._policy(parameters, evaluation), self.folder / "bundle")
        summary = plain(self._summary(evaluation))
        kept = {"format": FORMAT, **summary, "stopped": stopped}
        write_document(self.folder / "summary.json", kept)
        return summary

    def _policy(self, parameters: Parameters, evaluation: Evaluation) -> Policy:
        config = self.config
        return Policy(
            config.scene,
            config.mode,
            config.method,
            config.training.seed,
            config.training.algorithm,
            parameters,
            evaluation.success_rate,
            evaluation.robustness_mean,
            self.epochs,
        )

    def _summary(self, evaluation: Evaluation) -> dict[str, Any]:
        config, environments = self.config, self.config.training.algorithm.environments
        return {
            "task": config.scene.name,
            "method": config.method,
            "mode": config.mode,
            "seed": config.training.seed,
            "success_rate": evaluation.success_rate,
            "robustness_mean": evaluation.robustness_mean,
            "epochs": self.epochs,
            "env_steps": self.epochs * environments * self.task.steps,
            "train_seconds": 0.0 if self.state is None else round(float(self.state.seconds), 3),
            "compile_seconds": round(self.compile_seconds, 3),
            "out": str(self.folder),
        }

    def close(self) -> None:
        """Close the event file; a full disk costs no more than its last points."""
        with suppress(OSError):
            self._events.close()

    def __enter__(self) -> "Run":
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def report(progress: Progress) -> dict[str, Any]:
    """What an epoch's line says, ready for JSON."""
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


def _keep_metrics(path: Path, epochs: int) -> None:
    """Drop the lines of later epochs, and a last line that was cut off."""
    if not path.exists():
        return
    kept = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            epoch = json.loads(line)["epoch"]
        except (ValueError, TypeError, KeyError):
            continue
        if isinstance(epoch, int) and epoch <= epochs:
            kept.append(line + "\n")
    write_atomically(path, "".join(kept).encode())
