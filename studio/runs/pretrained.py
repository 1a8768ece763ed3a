"""The weights that come with the program: one set per robot, which answers before any training.

`static/policies/<robot>.safetensors` holds the weights, `<robot>.json` their card: the
hyper-parameters, what they were trained on, and what was measured on what they were not.
`--pretrain` makes both.
"""

from dataclasses import dataclass
from importlib import resources
from importlib.resources.abc import Traversable
from math import nan
from pathlib import Path
from typing import Any

from core.checkpoint import load_tree, require_finite, save_tree
from core.controller import Controller
from core.methods import METHODS
from core.methods.tgpo.algorithm import Algorithm
from core.task.task import Task
from scenes import Scene
from studio.runs.bundle import Policy, weights_like
from studio.runs.held_out import HeldOut
from studio.runs.json_documents import (
    Document,
    DocumentError,
    Epochs,
    Seed,
    read_algorithm,
    read_document,
    write_document,
)

FORMAT = 2
"""Version of the card."""


class Card(Document, kw_only=True, frozen=True):
    """The file `<robot>.json`."""

    robot: str
    mode: str
    method: str
    seed: Seed
    epochs: Epochs
    env_steps: int
    train_seconds: float
    families: tuple[str, ...]
    """What the missions of the training were drawn from."""
    held_out: tuple[HeldOut, ...]
    """What the weights reach on tasks that they were not trained on."""
    algorithm: dict[str, Any]


@dataclass(frozen=True, eq=False)
class Pretrained:
    """Weights of a robot, good for any of its tasks."""

    algorithm: Any
    weights: Any
    card: Card

    @property
    def controller(self) -> Controller:
        """What carries out schedules of any task of the robot."""
        return METHODS[self.card.method].controller(self.algorithm, self.weights)

    def policy(self, scene: Scene, success: float = nan, robustness: float = nan) -> Policy:
        """The weights as the policy of a scene, NaN for what was not measured."""
        card = self.card
        return Policy(
            scene,
            card.mode,
            card.method,
            card.seed,
            self.algorithm,
            self.weights,
            success,
            robustness,
            card.epochs,
        )


def has_weights(robot: str) -> bool:
    """Whether weights are shipped for a robot."""
    return _shipped(robot).is_file()


def fitting(card: Card, algorithm: Any) -> bool:
    """Whether weights can go on learning by an algorithm: networks and features are the same."""
    if not isinstance(algorithm, Algorithm) or algorithm.mode_name != card.mode:
        return False
    learnt = read_algorithm(card.algorithm, card.method, card.mode, card.robot)
    return _networks(learnt) == _networks(algorithm)


def shipped_weights_fit(robot: str, algorithm: Any) -> bool:
    """Whether a training of a robot can begin with shipped weights."""
    if not has_weights(robot):
        return False
    with resources.as_file(_shipped(robot)) as path:
        return fitting(read_document(path, FORMAT, Card), algorithm)


def shipped_weights(task: Task) -> Pretrained | None:
    """The weights that are shipped for a task's robot, None if there are none.

    Raises:
        UserError: the files are damaged.
    """
    name = task.robot.name
    if not has_weights(name):
        return None
    with resources.as_file(resources.files("static") / "policies") as path:
        return load_weights(path / f"{name}.safetensors", task)


def load_weights(path: Path, task: Task) -> Pretrained:
    """Weights from a file, its card beside it.

    Raises:
        UserError: a file that is missing or damaged, or weights for another robot.
    """
    document = path.with_suffix(".json")
    card = read_document(document, FORMAT, Card)
    if card.robot != task.robot.name:
        raise DocumentError(
            f"{document}: weights of the robot {card.robot!r}, but the task is for "
            f"{task.robot.name!r}"
        )
    algorithm = read_algorithm(card.algorithm, card.method, card.mode, str(document))
    if not METHODS[card.method].chooses_times:
        raise DocumentError(
            f"{document}: method: weights of {card.method} do not serve every task; train them "
            "with --train-only. Allowed: tgpo, tgpo-star"
        )
    weights = load_tree(path, weights_like(task, card.method, algorithm), kind="weights")
    require_finite(weights, str(path))
    return Pretrained(algorithm, weights, card)


def chosen_weights(source: str, task: Task) -> Pretrained | None:
    """Weights by the option --weights: `shipped`, `none`, or the path of a file.

    Raises:
        UserError: as `load_weights`.
    """
    if source == "none":
        return None
    return shipped_weights(task) if source == "shipped" else load_weights(Path(source), task)


def _networks(algorithm: Algorithm) -> tuple[Any, ...]:
    """What must be equal for the networks of two algorithms to be alike."""
    mode = algorithm.mode
    return algorithm.hidden, getattr(mode, "dangers", None), getattr(mode, "ahead", None)


def _shipped(robot: str) -> Traversable:
    """The card of a robot's shipped weights, whether there are any or not."""
    return resources.files("static") / "policies" / f"{robot}.json"


def save_weights(path: Path, weights: Any, card: Card) -> None:
    """Write the weights and, beside them, their card."""
    path.parent.mkdir(parents=True, exist_ok=True)
    save_tree(path, weights, kind="weights")
    write_document(path.with_suffix(".json"), card)
