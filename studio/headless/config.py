"""What a run is asked for, and its file config.json.

The file holds all hyper-parameters, not only the names of their presets: a run goes on, and a
reader understands it, even where a later version has other presets.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from core.algorithm import make_algorithm, many_layouts
from core.errors import UserError
from core.task import Task
from core.training import TrainingConfig
from scenes import Scene, format_scene, parse_scene
from studio.files.json_documents import (
    DocumentError,
    algorithm_document,
    read_algorithm,
    read_document,
)
from studio.layouts import randomized
from studio.tasks import build_task

FORMAT = 1
"""Version of the run directories that this program reads and writes."""

EPOCHS = {"studio": 200, "paper": 1000}
"""Most epochs of a run by default; Table A.1 for `paper` (Linear, Unicycle)."""

STUDIO_EPOCHS = {"ant": 60}
"""The same in studio mode for robots whose last epochs are dear."""


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

    def build_task(self) -> Task:
        """The grounded task, with the layouts that the training learns on.

        Raises:
            UserError: a formula or scene that cannot be grounded.
        """
        algorithm, seed = self.training.algorithm, self.training.seed
        return randomized(self.scene, build_task(self.scene), algorithm, seed)

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
    randomize: bool = False,
) -> RunConfig:
    """Configuration of a run; None stands for the default.

    Raises:
        UserError: a value that is not allowed.
    """
    algorithm = make_algorithm(mode, method, scene.robot)  # pyright: ignore[reportArgumentType]
    if mode == "paper" and scene.variant == "links":
        raise RunError("the paper's mode looks at the end effector alone. Available: ['studio']")
    if randomize:
        algorithm = many_layouts(algorithm)
    default_epochs = EPOCHS[mode]
    if mode == "studio":
        default_epochs = STUDIO_EPOCHS.get(scene.robot, default_epochs)
    default = TrainingConfig(
        algorithm, seed=scene.seed if seed is None else seed, epochs=default_epochs
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
