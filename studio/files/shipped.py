"""Trained policies that come with the program, so that the page opens on a solved task.

`static/policies/<task>.safetensors` holds the weights, `<task>.json` the hyper-parameters and what
was measured. `tests.tools.ship_policies` makes them.
"""

from importlib import resources
from pathlib import Path

from core.checkpoint import load_tree, save_tree
from core.programs import fresh_learner
from core.task import Task
from scenes import Scene, load_task
from studio.files.bundle import Policy
from studio.files.json_documents import (
    algorithm_document,
    read_algorithm,
    read_document,
    write_document,
)

FORMAT = 1
"""Version of the metadata."""

SHIPPED = (
    "linear-08",
    "unicycle-08",
    "linear-demo",
    "unicycle-demo",
    "panda-demo",
    "quadrotor-demo",
    "ant-demo",
)
"""Tasks with a policy."""


def shipped_policy(scene: Scene, task: Task) -> Policy | None:
    """The policy for a shipped task as it is; None if there is none, or the scene was edited.

    Raises:
        UserError: the files are damaged.
    """
    if scene.name not in SHIPPED or scene != load_task(scene.name):
        return None
    folder = resources.files("static") / "policies"
    with (
        resources.as_file(folder / f"{scene.name}.json") as document,
        resources.as_file(folder / f"{scene.name}.safetensors") as weights,
    ):
        return _read(document, weights, scene, task)


def save_shipped(policy: Policy, folder: Path) -> None:
    """Write the two files of a policy."""
    folder.mkdir(parents=True, exist_ok=True)
    name = policy.scene.name
    save_tree(folder / f"{name}.safetensors", policy.parameters, kind="weights")
    write_document(
        folder / f"{name}.json",
        {
            "format": FORMAT,
            "task": name,
            "mode": policy.mode,
            "method": policy.method,
            "seed": policy.seed,
            "epochs": policy.epochs,
            "success_rate": policy.success_rate,
            "robustness_mean": policy.robustness_mean,
            "algorithm": algorithm_document(policy.algorithm),
        },
    )


def _read(document: Path, weights: Path, scene: Scene, task: Task) -> Policy:
    number = (int, float)
    values = read_document(
        document,
        FORMAT,
        {"mode": str, "method": str, "seed": int, "epochs": int, "algorithm": dict}
        | {"success_rate": number, "robustness_mean": number},
    )
    algorithm = read_algorithm(values["algorithm"], values["mode"], str(document))
    like = fresh_learner(task, algorithm, 0).parameters
    return Policy(
        scene,
        values["mode"],
        values["method"],
        values["seed"],
        algorithm,
        load_tree(weights, like, kind="weights"),
        values["success_rate"],
        values["robustness_mean"],
        values["epochs"],
    )
