"""Every method on every robot: trained for an epoch, evaluated, exported, and loaded again.

    python -m tests.tools.cells                      all robots and methods, their tasks 01 and 08
    python -m tests.tools.cells --robots ant --methods cem grad --tasks 01

The commands are those of a user: `tgpo-studio --train-only`, then `tgpo-studio --evaluate` on the
bundle, which must find the same success and robustness; and the bundle's exported programs drive
the robot, whose actions must be those of our own rollout. After one epoch nothing has been learnt:
this says that a cell of the table works, and nothing about its quality. Prints a Markdown table;
exit status 1 if a cell failed.
"""

import argparse
import contextlib
import io
import json
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import jax
import jax.numpy as jnp
import numpy as np
from jax import export

from core.controller import pad_schedule
from core.methods import METHODS
from core.rollout import roll_out
from envs import ENVS
from studio.cli import main as tgpo_studio
from studio.runs.bundle import load_bundle
from studio.runs.tasks import build_task, initial_state

TASKS = ("01", "08")
"""One of two layers, one of more."""
TOLERANCE = 1e-4
"""Largest difference between an action of the exported programs and one of our own."""
COLUMNS = ("robot", "method", "task", "works", "robustness [m]", "actions differ by", "took [s]")


class CellError(Exception):
    """What does not work."""


def said_by(arguments: Sequence[str]) -> tuple[int, dict[str, Any], str]:
    """Exit status, last line as JSON, and last line of the errors of `tgpo-studio`."""
    out, errors = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(errors):
        status = tgpo_studio(arguments)
    lines, said = out.getvalue().splitlines(), errors.getvalue().strip().splitlines()
    return status, json.loads(lines[-1]) if status == 0 else {}, said[-1] if said else ""


def exported_difference(bundle: Path) -> float:
    """Largest difference between actions of a bundle's programs and of our own rollout."""
    policy = load_bundle(bundle)
    task = build_task(policy.scene)
    controller = METHODS[policy.method].controller(policy.algorithm, policy.weights)
    formula = task.problem.formula
    count = len(task.grounding.decomposition.variables)
    times = ((np.asarray(formula.low) + np.asarray(formula.high)) // 2)[:count].astype(np.int32)
    state = initial_state(task)
    schedule = pad_schedule(task.problem, jnp.asarray(times))
    rollout = roll_out(task, controller, state[None], schedule[None])
    start, step = (
        export.deserialize(bytearray((bundle / f"{name}.stablehlo").read_bytes())).call
        for name in ("start", "step")
    )
    visited = rollout.states[: task.horizon, 0]

    @jax.jit
    def drive(visited: jax.Array) -> jax.Array:
        return jax.lax.scan(cast(Any, step), start(visited[0], jnp.asarray(times)), visited)[1]

    return float(jnp.abs(drive(visited) - rollout.actions[: task.horizon, 0]).max())


def works(task: str, method: str, folder: Path) -> tuple[str, str, str]:
    """Whether a cell works, its mean robustness, and by how much the exported actions differ.

    Raises:
        CellError: it does not.
    """
    status, trained, error = said_by(
        ["--train-only", "--task", task, "--method", method, "--weights", "none"]
        + ["--epochs", "1", "--out", str(folder)]
    )
    if status == 2:  # noqa: PLR2004 - what the method or the scene does not allow
        return f"refused: {error.removeprefix('error: ')}", "", ""
    if status:
        raise CellError(error)
    status, again, error = said_by(["--evaluate", str(folder / "bundle")])
    if status:
        raise CellError(error)
    for number in ("success_rate", "robustness_mean"):
        if trained[number] != again[number]:
            raise CellError(f"{number}: {trained[number]} trained, {again[number]} loaded")
    difference = exported_difference(folder / "bundle")
    if not difference <= TOLERANCE:
        raise CellError(f"exported actions differ by {difference:g}")
    return "yes", f"{trained['robustness_mean']:.3f}", f"{difference:.1e}"


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=sorted(ENVS), choices=sorted(ENVS))
    parser.add_argument("--methods", nargs="+", default=list(METHODS), choices=list(METHODS))
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    options = parser.parse_args()
    print(f"| {' | '.join(COLUMNS)} |\n|{' --- |' * len(COLUMNS)}", flush=True)
    failed = 0
    for robot in options.robots:
        for method in options.methods:
            for task in options.tasks:
                began = time.monotonic()
                with tempfile.TemporaryDirectory() as folder:
                    try:
                        found = works(f"{robot}-{task}", method, Path(folder) / "run")
                    except CellError as error:
                        failed += 1
                        found = f"no: {error}", "", ""
                cells = (robot, method, task, *found, f"{time.monotonic() - began:.0f}")
                print(f"| {' | '.join(cells)} |", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
