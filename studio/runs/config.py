"""The configuration of a run, and its file config.json.

The file holds all hyper-parameters, not only the names of their presets, so that a run can be
resumed and understood even if a later version has other presets.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from core.documents import typed
from core.errors import UserError
from core.methods import METHODS
from core.methods.tgpo.algorithm import many_layouts
from core.methods.training import RunState, TrainingConfig, state_from_weights
from core.task.task import Task
from scenes import Scene, format_scene, parse_scene, robot_of
from studio.runs.json_documents import (
    Document,
    DocumentError,
    Seed,
    algorithm_document,
    read_algorithm,
    read_document,
)
from studio.runs.layouts import randomized
from studio.runs.missions import with_missions
from studio.runs.pretrained import chosen_weights, shipped_weights_fit
from studio.runs.tasks import build_task

FORMAT = 1
"""Version of the run directories that this program reads and writes."""

PAPER_EPOCHS = 1000
"""Most epochs of a run by default in paper mode: Table A.1 (Linear, Unicycle)."""


class RunError(UserError):
    """A run directory that cannot be made, read or continued."""


MostEpochs = Annotated[int, Meta(ge=1, le=10**6)]
TimeLimit = Annotated[float, Meta(gt=0)]  # [s]
Target = Annotated[float, Meta(gt=0, le=10**6)]  # above 1: trains to the last epoch
Interval = Annotated[int, Meta(ge=1)]  # [epochs]


class Budget(msgspec.Struct):
    """Bounds of the numbers that a run is asked for with."""

    seed: Seed
    epochs: MostEpochs
    time_limit: TimeLimit
    target: Target
    evaluate_every: Interval


class ConfigDocument(Document, kw_only=True, frozen=True):
    """The file config.json."""

    task: str = ""
    robot: str = ""
    formula: str
    """The scene's, for whoever reads the file."""
    mode: str
    method: str
    seed: Seed
    epochs: MostEpochs
    time_limit: TimeLimit | None
    """None for no limit."""
    target: Target
    evaluate_every: Interval
    algorithm: dict[str, Any]
    scene: str
    """As TOML."""
    weights: str = "none"
    """What the training began with: `none`, `shipped` or the path of a file."""
    missions: bool = False
    """Whether it learns on random missions of the robot, not on the scene."""


@dataclass(frozen=True)
class RunConfig:
    """The configuration of a run."""

    scene: Scene
    """With the formula to train on."""
    mode: str
    training: TrainingConfig
    weights: str = "none"
    """What the training begins with (see `studio.runs.pretrained.chosen_weights`)."""
    missions: bool = False
    """Whether it learns on random missions of the robot, not on the scene."""

    @property
    def name(self) -> str:
        """What a run is called after."""
        return f"{self.scene.robot}-weights" if self.missions else self.scene.name

    @property
    def method(self) -> str:
        """Name of the method."""
        return self.training.method

    def build_task(self, *, force: bool = False) -> Task:
        """The grounded task, with the layouts that the training learns on.

        Args:
            force: whether a mission that cannot be carried out is grounded all the same.

        Raises:
            UserError: a formula or scene that cannot be grounded.
        """
        algorithm, seed = self.training.algorithm, self.training.seed
        if self.missions:
            return with_missions(build_task(self.scene, shared=True), self.scene.robot, seed)
        return randomized(self.scene, build_task(self.scene, force=force), algorithm, seed)

    def first_state(self, task: Task) -> RunState | None:
        """State before the first epoch where the training begins with weights, else None.

        Raises:
            UserError: a file of weights that is missing, damaged or for another robot.
        """
        found = chosen_weights(self.weights, task)
        return None if found is None else state_from_weights(task, self.training, found.weights)

    def document(self) -> ConfigDocument:
        """The content of config.json."""
        scene, training = self.scene, self.training
        return ConfigDocument(
            format=FORMAT,
            task=scene.name,
            robot=scene.robot,
            formula=scene.formula,
            mode=self.mode,
            method=self.method,
            seed=training.seed,
            epochs=training.epochs,
            time_limit=training.time_limit if math.isfinite(training.time_limit) else None,
            target=training.target,
            evaluate_every=training.evaluate_every,
            algorithm=algorithm_document(training.algorithm),
            scene=format_scene(scene),
            weights=self.weights,
            missions=self.missions,
        )


def make_config(
    scene: Scene,
    *,
    mode: str = "studio",
    method: str = "tgpo-star",
    seed: int | None = None,
    epochs: int | None = None,
    time_limit: float | None = None,
    target: float | None = None,
    randomize: bool = False,
    weights: str | None = None,
) -> RunConfig:
    """Configuration of a run; None stands for the default.

    By default a training in studio mode begins with the robot's shipped weights.

    Raises:
        UserError: a value that is not allowed.
    """
    robot = robot_of(scene)
    if method not in METHODS:
        raise RunError(f"unknown method {method!r}. Available: {sorted(METHODS)}")
    algorithm = METHODS[method].preset(mode, robot)
    if not METHODS[method].chooses_times:
        _refuse_beside(method, randomize, weights)
    if randomize:
        algorithm = many_layouts(algorithm)
    default = TrainingConfig(
        algorithm,
        method,
        seed=scene.seed if seed is None else seed,
        epochs=PAPER_EPOCHS if mode == "paper" else robot.tuning.epochs,
    )
    training = with_budget(default, epochs=epochs, time_limit=time_limit, target=target)
    if weights is None:
        weights = "shipped" if shipped_weights_fit(scene.robot, algorithm) else "none"
    return RunConfig(scene, mode, replace(training, warm=weights != "none"), weights)


def _refuse_beside(method: str, randomize: bool, weights: str | None) -> None:
    """Refuse what a method that carries out a formula as a whole cannot do."""
    if randomize:
        raise RunError(f"--randomize: {method} learns a single layout only. Available: tgpo-star")
    if weights not in (None, "none"):
        raise RunError(
            f"--weights: {method} begins from scratch; weights that serve every task are those of "
            "tgpo-star. Allowed: none"
        )


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
    try:
        typed({name: getattr(training, name) for name in Budget.__struct_fields__}, Budget)
    except UserError as error:
        raise RunError(str(error)) from error
    return training


def read_config(folder: Path) -> RunConfig:
    """Configuration of a run.

    Raises:
        UserError: not a run, one of another version, or a damaged config.json.
    """
    path = folder / "config.json"
    if not path.is_file():
        raise RunError(f"{folder}: not a run (config.json is missing)")
    read = read_document(path, FORMAT, ConfigDocument)
    scene = parse_scene(read.scene, f"{path}: scene")
    if scene.formula.strip() != read.formula.strip():
        raise DocumentError(f"{path}: formula: differs from the formula of its scene")
    training = TrainingConfig(
        read_algorithm(read.algorithm, read.method, read.mode, str(path)),
        read.method,
        seed=read.seed,
        epochs=read.epochs,
        time_limit=math.inf if read.time_limit is None else read.time_limit,
        target=read.target,
        evaluate_every=read.evaluate_every,
        warm=read.weights != "none",
    )
    return RunConfig(scene, read.mode, training, read.weights, read.missions)
