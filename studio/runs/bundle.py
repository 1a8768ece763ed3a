"""Policy bundles: a folder with a trained policy, to evaluate here or to run elsewhere.

    task.stl.toml          the scene with the formula that was trained on
    weights.safetensors    actor and critic (float32)
    metadata.json          versions, robot, mode, method, seed, hyper-parameters, measured success,
                           checksums of the files above and below
    score|start|step.stablehlo   the closed-loop controller, to be run with nothing but jax
    rescore.stablehlo            for times anew in the middle of an episode
    README.txt             how to do so

The folder appears as a whole, by a rename: no reader sees a partial bundle.
"""

import glob
import hashlib
import platform
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import jax

from core.checkpoint import load_tree, require_finite, save_tree
from core.controller import Controller
from core.documents import Share
from core.errors import UserError
from core.evaluation import EVALUATION_STATES
from core.methods import METHODS
from core.task.grounding import Grounding
from core.task.task import Task
from scenes import Scene, load_scene, robot_of, save_scene
from studio.runs.controller import PLATFORMS, export_controller
from studio.runs.json_documents import (
    Document,
    DocumentError,
    Epochs,
    Seed,
    algorithm_document,
    read_algorithm,
    read_document,
    write_document,
)
from studio.runs.readme import readme
from studio.runs.tasks import build_task

FORMAT = 1
"""Version of the bundles that this program reads and writes."""

SCENE, WEIGHTS, METADATA = "task.stl.toml", "weights.safetensors", "metadata.json"
PROGRAMS = ("score.stablehlo", "start.stablehlo", "step.stablehlo")
CHECKED = (SCENE, WEIGHTS, *PROGRAMS)
"""Files with a checksum that every bundle has; the README is for people."""

RESCORE = "rescore.stablehlo"
"""Has a checksum too; bundles of earlier versions do without it."""


class BundleError(DocumentError):
    """A policy bundle that cannot be written, read or used."""


class Metadata(Document, kw_only=True, frozen=True):
    """The file metadata.json; what has a default is only for whoever reads it."""

    tgpo_studio: str = ""
    jax: str = ""
    python: str = ""
    robot: str
    task: str = ""
    formula: str = ""
    mode: str
    method: str
    seed: Seed
    epochs: Epochs
    success_rate: Share | None
    robustness_mean: float | None
    initial_states: int = EVALUATION_STATES
    algorithm: dict[str, Any]
    controller: dict[str, Any] = {}
    sha256: dict[str, str] = {}
    """Checksum of each file; bundles of earlier versions have none."""


@dataclass(frozen=True)
class Policy:
    """A trained policy and where it comes from."""

    scene: Scene
    """With the formula that was trained on."""
    mode: str
    method: str
    seed: int
    algorithm: Any
    """Hyper-parameters of the method."""
    weights: Any
    success_rate: float
    """Measured on initial states not used in training."""
    robustness_mean: float
    epochs: int

    @property
    def controller(self) -> Controller:
        """What carries the policy out."""
        return METHODS[self.method].controller(self.algorithm, self.weights)


def save_bundle(policy: Policy, folder: Path) -> None:
    """Write a bundle; an existing bundle is replaced as a whole.

    Raises:
        BundleError: the folder contains something else, or cannot be written.
        DivergedError: the weights are not finite.
    """
    require_finite(policy.weights, str(folder))
    task = build_task(policy.scene, force=True)
    programs = export_controller(task, policy.controller)
    with _replaced(folder) as fresh:
        save_scene(policy.scene, fresh / SCENE)
        save_tree(fresh / WEIGHTS, policy.weights, kind="weights")
        for name, program in programs.items():
            (fresh / f"{name}.stablehlo").write_bytes(program)
        write_document(fresh / METADATA, _metadata(policy, task, _checksums(fresh)))
        (fresh / "README.txt").write_text(
            readme(
                policy.scene,
                task,
                policy.success_rate,
                chooses_times=METHODS[policy.method].chooses_times,
            ),
            encoding="utf-8",
        )


def load_bundle(folder: Path) -> Policy:
    """Read a bundle.

    Raises:
        UserError: not a bundle, one of another version, or a missing or damaged file.
    """
    if not (folder / METADATA).is_file():
        raise BundleError(f"{folder}: not a policy bundle ({METADATA} is missing)")
    for name in CHECKED:
        if not (folder / name).is_file():
            raise BundleError(f"{folder}: the bundle is incomplete: {name} is missing")
    path = folder / METADATA
    read = read_document(path, FORMAT, Metadata)
    scene = load_scene(folder / SCENE)
    if read.robot != scene.robot:
        raise BundleError(f"{path}: robot: {read.robot!r}, but {SCENE} is for {scene.robot!r}")
    algorithm = read_algorithm(read.algorithm, read.method, read.mode, str(path))
    like = weights_like(build_task(scene, force=True), read.method, algorithm)
    weights = load_tree(folder / WEIGHTS, like, kind="weights")
    require_finite(weights, str(folder / WEIGHTS))
    _check_files(folder, read.sha256)
    return Policy(
        scene,
        read.mode,
        read.method,
        read.seed,
        algorithm,
        weights,
        _float(read.success_rate),
        _float(read.robustness_mean),
        read.epochs,
    )


def weights_like(task: Task, method: str, algorithm: Any) -> Any:
    """Stands for weights of the shapes that a method learns for a task."""
    return METHODS[method].learner(task, algorithm).weight_shapes()


def bundle_folder(path: Path) -> Path:
    """The bundle of a run directory, or the bundle itself.

    Raises:
        UserError: the path is neither.
    """
    if (path / METADATA).is_file():
        return path
    if (path / "bundle").is_dir():
        return path / "bundle"
    if (path / "config.json").is_file():
        raise UserError(f"{path}: this run has no policy yet; finish it with --resume {path}")
    raise UserError(f"{path}: neither a run nor a policy bundle ({METADATA} is missing)")


def version() -> str:
    """Version of this program, as installed."""
    try:
        return metadata.version("tgpo-studio")
    except metadata.PackageNotFoundError:
        return "not installed"


def _float(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _checksums(folder: Path) -> dict[str, str]:
    """SHA-256 of the files that are read again, by name."""
    found = {}
    extra = (RESCORE,) if (folder / RESCORE).is_file() else ()
    for name in (*CHECKED, *extra):
        with (folder / name).open("rb") as file:
            found[name] = hashlib.file_digest(file, "sha256").hexdigest()
    return found


def _check_files(folder: Path, expected: dict[str, str]) -> None:
    """Compare the files with their checksums, where the bundle has any."""
    if not expected:
        return
    for name, found in _checksums(folder).items():
        if expected.get(name) != found:
            raise BundleError(
                f"{folder}: {name} is not the file that was saved: its checksum differs from "
                f"the one in {METADATA}"
            )


def _metadata(policy: Policy, task: Task, checksums: dict[str, str]) -> Metadata:
    robot = robot_of(policy.scene)
    return Metadata(
        format=FORMAT,
        tgpo_studio=version(),
        jax=jax.__version__,
        python=platform.python_version(),
        robot=robot.name,
        task=policy.scene.name,
        formula=policy.scene.formula,
        mode=policy.mode,
        method=policy.method,
        seed=policy.seed,
        epochs=policy.epochs,
        success_rate=policy.success_rate,
        robustness_mean=policy.robustness_mean,
        initial_states=EVALUATION_STATES,
        algorithm=algorithm_document(policy.algorithm),
        controller={
            "platforms": PLATFORMS,
            "steps": task.horizon,
            "state": robot.state_names,
            "action": robot.action_names,
            "variables": _variables(task.grounding),
            "robot_constants": asdict(robot),  # pyright: ignore[reportArgumentType]
        },
        sha256=checksums,
    )


def _variables(grounding: Grounding) -> list[dict[str, Any]]:
    """Names and domains of the entries of a schedule."""
    return [
        {"name": v.name, "low": v.low, "high": v.high, "kind": v.kind, "labels": v.labels}
        for v in grounding.decomposition.variables
    ]


@contextmanager
def _replaced(folder: Path) -> Iterator[Path]:
    """A fresh folder that replaces `folder` once everything in it is written."""
    if folder.exists() and any(folder.iterdir()) and not (folder / METADATA).is_file():
        raise BundleError(
            f"{folder}: contains something other than a policy bundle; nothing was written"
        )
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        _remove_beside(folder)  # left by writers that were killed
        fresh, old = _beside(folder), _beside(folder)
        yield fresh
        if folder.exists():
            folder.rename(old / folder.name)
        fresh.rename(folder)
    except OSError as error:
        raise BundleError(f"{folder}: cannot be written: {error.strerror}") from error
    finally:
        _remove_beside(folder)


def _beside(folder: Path) -> Path:
    path = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
    path.chmod(0o755)
    return path


def _remove_beside(folder: Path) -> None:
    for path in folder.parent.glob(f".{glob.escape(folder.name)}.*"):
        shutil.rmtree(path, ignore_errors=True)
