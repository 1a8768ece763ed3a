"""Runs: a directory that holds everything about one training, and from which it can go on.

    config.json       what was asked for: scene, formula, mode, method, seed, budget, all
                      hyper-parameters (never changes, but for the budget when a run is resumed)
    metrics.jsonl     one line an epoch
    tensorboard/      the same curves as TensorBoard events
    checkpoints/      the last two states of the training
    bundle/           the best policy (see `studio.bundle`)
    summary.json      what came out

A run that was stopped or killed goes on from its last checkpoint and ends with exactly what an
uninterrupted run gives.
"""

import json
import math
import re
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from core.algorithm import make_algorithm
from core.checkpoint import load_checkpoint, require_finite, save_checkpoint, write_atomically
from core.errors import UserError
from core.evaluation import Evaluation
from core.networks import Parameters
from core.task import Task
from core.training import Progress, RunState, TrainingConfig, final_evaluation, fresh_state
from scenes import Scene, format_scene, parse_scene
from studio.bundle import Policy, save_bundle
from studio.documents import (
    DocumentError,
    algorithm_document,
    plain,
    read_algorithm,
    read_document,
    write_document,
)
from studio.events import EventLog
from studio.tasks import build_task

FORMAT = 1
"""Version of the run directories that this program reads and writes."""

CHECKPOINT_SECONDS = 5.0
"""Training time between checkpoints at most, unless one epoch takes longer [s]."""

EPOCHS = {"studio": 200, "paper": 1000}
"""Most epochs of a run by default; Table A.1 for `paper` (Linear, Unicycle)."""


class RunError(UserError):
    """A run directory that cannot be made, read or continued."""


@dataclass(frozen=True)
class RunConfig:
    """What a run is asked for."""

    scene: Scene
    """With the formula to train on."""
    mode: str
    method: str
    training: TrainingConfig

    def document(self) -> dict[str, Any]:
        """As JSON values; `formula` stands beside the scene for whoever reads the file."""
        training = self.training
        return {
            "format": FORMAT,
            "task": self.scene.name,
            "robot": self.scene.robot,
            "formula": self.scene.formula,
            "mode": self.mode,
            "method": self.method,
            "seed": training.seed,
            "epochs": training.epochs,
            "time_limit": training.time_limit,  # null for none
            "target": training.target,
            "evaluate_every": training.evaluate_every,
            "algorithm": algorithm_document(training.algorithm),
            "scene": format_scene(self.scene),
        }


def make_config(
    scene: Scene,
    *,
    mode: str = "studio",
    method: str = "tgpo-star",
    seed: int | None = None,
    epochs: int | None = None,
    time_limit: float | None = None,
    target: float | None = None,
) -> RunConfig:
    """Configuration of a run; None stands for the default.

    Raises:
        UserError: a value that is not allowed.
    """
    algorithm = make_algorithm(mode, method, scene.robot)  # pyright: ignore[reportArgumentType]
    default = TrainingConfig(
        algorithm, seed=scene.seed if seed is None else seed, epochs=EPOCHS[mode]
    )
    training = with_budget(default, epochs=epochs, time_limit=time_limit, target=target)
    return RunConfig(scene, mode, method, training)


def with_budget(
    training: TrainingConfig,
    *,
    epochs: int | None = None,
    time_limit: float | None = None,
    target: float | None = None,
) -> TrainingConfig:
    """The configuration with another budget, and everything checked.

    Raises:
        RunError: a value that is not allowed.
    """
    given = {"epochs": epochs, "time_limit": time_limit, "target": target}
    changed = {name: value for name, value in given.items() if value is not None}
    training = replace(training, **changed)
    checks = {
        "seed": (0 <= training.seed < 2**31, "an integer from 0 to 2147483647"),
        "epochs": (1 <= training.epochs <= 10**6, "an integer from 1 to 1000000"),
        "time_limit": (training.time_limit > 0, "a positive number of seconds"),
        "target": (0 < training.target < math.inf, "a positive share; above 1 trains to the end"),
        "evaluate_every": (training.evaluate_every >= 1, "a positive number of epochs"),
    }
    for name, (holds, allowed) in checks.items():
        if not holds:
            raise RunError(f"{name}: {getattr(training, name)} must be {allowed}")
    return training


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
        task = build_task(config.scene) if task is None else task
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
        task = build_task(config.scene)
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
            "success_rate": None if evaluation is None else evaluation.success_rate,
            "robustness_mean": None if evaluation is None else evaluation.robustness_mean,
        }
    )


def read_config(folder: Path) -> RunConfig:
    """Configuration of a run.

    Raises:
        UserError: no run, one of another version, or a config.json that was tampered with.
    """
    path = folder / "config.json"
    if not path.is_file():
        raise RunError(f"{folder}: no run (config.json is missing)")
    number = (int, float)
    values = read_document(
        path,
        FORMAT,
        {"scene": str, "formula": str, "mode": str, "method": str, "algorithm": dict}
        | {"seed": int, "epochs": int, "evaluate_every": int, "target": number}
        | {"time_limit": (int, float, type(None))},
    )
    scene = parse_scene(values["scene"], f"{path}: scene")
    if scene.formula.strip() != values["formula"].strip():
        raise DocumentError(f"{path}: formula: differs from the formula of its scene")
    limit = values["time_limit"]
    training = TrainingConfig(
        read_algorithm(values["algorithm"], values["mode"], str(path)),
        seed=values["seed"],
        epochs=values["epochs"],
        time_limit=math.inf if limit is None else float(limit),
        target=float(values["target"]),
        evaluate_every=values["evaluate_every"],
    )
    return RunConfig(scene, values["mode"], values["method"], with_budget(training))


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
