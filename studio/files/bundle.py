"""Policy bundles: a folder that holds a trained policy, to evaluate here or to run elsewhere.

    task.stl.toml          the scene with the formula that was trained on
    weights.safetensors    actor and critic (float32)
    metadata.json          versions, robot, mode, method, seed, hyper-parameters, measured success
    score|start|step.stablehlo   the closed-loop controller, to be run with nothing but jax
    README.txt             how to

The folder appears as a whole, by a rename: no reader meets the half of one.
"""

import glob
import platform
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from string import Template
from typing import Any

import jax

from core.algorithm import Algorithm
from core.checkpoint import load_tree, require_finite, save_tree
from core.grounding import Grounding
from core.networks import Parameters
from core.programs import EVALUATION_STATES, fresh_learner
from core.task import Task
from scenes import Scene, load_scene, save_scene
from studio.files.controller import PLATFORMS, export_controller
from studio.files.json_documents import (
    DocumentError,
    algorithm_document,
    read_algorithm,
    read_document,
    write_document,
)
from studio.tasks import build_task, robot_of

FORMAT = 1
"""Version of the bundles that this program reads and writes."""

SCENE, WEIGHTS, METADATA = "task.stl.toml", "weights.safetensors", "metadata.json"
PROGRAMS = ("score.stablehlo", "start.stablehlo", "step.stablehlo")


class BundleError(DocumentError):
    """A policy bundle that cannot be written, read or used."""


@dataclass(frozen=True)
class Policy:
    """A trained policy and where it comes from."""

    scene: Scene
    """With the formula that was trained on."""
    mode: str
    method: str
    seed: int
    algorithm: Algorithm
    parameters: Parameters
    success_rate: float
    """Measured on initial states that the training has not seen."""
    robustness_mean: float
    epochs: int


def save_bundle(policy: Policy, folder: Path) -> None:
    """Write a bundle; a bundle that is already there is replaced as a whole.

    Raises:
        BundleError: the folder holds something else, or cannot be written.
        DivergedError: the weights are not finite.
    """
    require_finite(policy.parameters, str(folder))
    task = build_task(policy.scene)
    programs = export_controller(task, policy.algorithm, policy.parameters)
    with _replaced(folder) as fresh:
        save_scene(policy.scene, fresh / SCENE)
        save_tree(fresh / WEIGHTS, policy.parameters, kind="weights")
        write_document(fresh / METADATA, _metadata(policy, task))
        for name in PROGRAMS:
            (fresh / name).write_bytes(programs[name.removesuffix(".stablehlo")])
        (fresh / "README.txt").write_text(_readme(policy, task), encoding="utf-8")


def load_bundle(folder: Path) -> Policy:
    """Read a bundle.

    Raises:
        UserError: no bundle, one of another version, a file is missing or was tampered with.
    """
    if not (folder / METADATA).is_file():
        raise BundleError(f"{folder}: no policy bundle ({METADATA} is missing)")
    for name in (SCENE, WEIGHTS, *PROGRAMS):
        if not (folder / name).is_file():
            raise BundleError(f"{folder}: the bundle is incomplete: {name} is missing")
    path = folder / METADATA
    number = (int, float, type(None))
    values = read_document(
        path,
        FORMAT,
        {"robot": str, "mode": str, "method": str, "seed": int, "epochs": int, "algorithm": dict}
        | {"success_rate": number, "robustness_mean": number},
    )
    scene = load_scene(folder / SCENE)
    if values["robot"] != scene.robot:
        raise BundleError(f"{path}: robot: {values['robot']!r}, but {SCENE} is for {scene.robot!r}")
    algorithm = read_algorithm(values["algorithm"], values["mode"], str(path))
    like = fresh_learner(build_task(scene), algorithm, 0).parameters
    parameters = load_tree(folder / WEIGHTS, like, kind="weights")
    require_finite(parameters, str(folder / WEIGHTS))
    return Policy(
        scene,
        values["mode"],
        values["method"],
        values["seed"],
        algorithm,
        parameters,
        _float(values["success_rate"]),
        _float(values["robustness_mean"]),
        values["epochs"],
    )


def version() -> str:
    """Version of this program, as installed."""
    try:
        return metadata.version("tgpo-studio")
    except metadata.PackageNotFoundError:
        return "not installed"


def _float(value: float | None) -> float:
    return float("nan") if value is None else float(value)


def _metadata(policy: Policy, task: Task) -> dict[str, Any]:
    robot = robot_of(policy.scene)
    return {
        "format": FORMAT,
        "tgpo_studio": version(),
        "jax": jax.__version__,
        "python": platform.python_version(),
        "robot": robot.name,
        "task": policy.scene.name,
        "formula": policy.scene.formula,
        "mode": policy.mode,
        "method": policy.method,
        "seed": policy.seed,
        "epochs": policy.epochs,
        "success_rate": policy.success_rate,
        "robustness_mean": policy.robustness_mean,
        "initial_states": EVALUATION_STATES,
        "algorithm": algorithm_document(policy.algorithm),
        "controller": {
            "platforms": PLATFORMS,
            "steps": task.horizon,
            "state": robot.state_names,
            "action": robot.action_names,
            "variables": _variables(task.grounding),
            "robot_constants": asdict(robot),  # pyright: ignore[reportArgumentType]
        },
    }


def _variables(grounding: Grounding) -> list[dict[str, Any]]:
    """Names and domains of the entries of a schedule."""
    return [
        {"name": v.name, "low": v.low, "high": v.high, "kind": v.kind, "labels": v.labels}
        for v in grounding.decomposition.variables
    ]


@contextmanager
def _replaced(folder: Path) -> Iterator[Path]:
    """A fresh folder that takes the place of `folder` when everything in it is written."""
    if folder.exists() and any(folder.iterdir()) and not (folder / METADATA).is_file():
        raise BundleError(f"{folder}: holds something else than a policy bundle; nothing written")
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        _remove_beside(folder)  # what writers that were killed have left
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


def _readme(policy: Policy, task: Task) -> str:
    robot = robot_of(policy.scene)
    variables = task.grounding.decomposition.variables
    center = [*policy.scene.initial.center]
    state = center + [0.0] * (robot.state_size - len(center))
    return _README.substitute(
        task=policy.scene.name,
        robot=robot.name,
        formula=" ".join(policy.scene.formula.split()),
        success=f"{100 * policy.success_rate:.1f} %",
        states=EVALUATION_STATES,
        state_names=", ".join(robot.state_names),
        action_names=", ".join(robot.action_names),
        variables=", ".join(f"{v.name} in [{v.low}, {v.high}]" for v in variables) or "none",
        low=[v.low for v in variables],
        high=[v.high for v in variables],
        count=len(variables),
        state=state,
        steps=task.horizon,
        dt=robot.dt,
    )


_README = Template("""\
A policy for the task $task of the robot "$robot", trained by TGPO Studio

    $formula

It succeeded from $success of $states random initial states.

To evaluate it here:   tgpo-studio --evaluate THIS_FOLDER

To run it without TGPO Studio, in this folder, with nothing but jax (and flatbuffers, which jax
needs to read programs: pip install jax flatbuffers):

    import jax
    import numpy as np
    from jax import export

    def load(name):
        with open(name + ".stablehlo", "rb") as file:
            return jax.jit(export.deserialize(bytearray(file.read())).call)

    score, start, step = load("score"), load("start"), load("step")
    x = np.array($state, np.float32)  # the state now
    low, high = np.array($low, np.int32), np.array($high, np.int32)
    candidates = np.random.default_rng(0).integers(low, high + 1, (64, $count), np.int32)
    t = max(candidates, key=lambda t: float(score(x, t)))  # the schedule of highest value
    s = start(x, t)
    for k in range($steps):
        s, action = step(s, x)
        x = your_robot(x, action)  # what the robot measures $dt s later

The state is ($state_names), float32. The action ($action_names) is in [-1, 1] in units of the
robot's limits, which are under "robot_constants" in metadata.json. The schedule t holds the
formula's time variables in steps, int32: $variables.
s is the controller's memory: a tuple of arrays to hand to the next call of step.
""")
