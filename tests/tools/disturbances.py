"""How the robots' weights take pushes, with and without planning anew.

    python -m tests.tools.disturbances                 all robots, their tasks 04, 08 and demo
    python -m tests.tools.disturbances ant --starts 8 --sizes 1 --pushes 2 --seeds 0 1 2

Starts are random; the same pushes are taken both ways. A push has a size in robot lengths (a tenth
of the workspace), a random direction, and comes at a random step before the plan's last subgoal is
over. Prints a Markdown table: rates are means over the seeds, +- their standard deviation.
"""

import argparse
import os
import platform
import time

import jax
import numpy as np

from core.attempts import tries
from core.compilation import compile_together, use_disk_cache
from core.disturbances import Pushes, Withstood, withstand
from core.replanning import replan_jobs
from core.rollout import start_states
from envs import ENVS
from scenes import load_task, robot_of
from studio.runs.pretrained import chosen_weights
from studio.runs.tasks import build_task

TASKS = ("04", "08", "demo")
COLUMNS = (
    *("task", "push [m]", "undisturbed", "as planned", "planned anew"),
    *("hopeless at once", "planning anew, median / p95 [s]"),
)


def measured(name: str, size: float, options: argparse.Namespace) -> list[Withstood]:
    """One measurement a seed, of pushes of a size [m]."""
    scene = load_task(name)
    task = build_task(scene)
    weights = chosen_weights("shipped", task)
    assert weights is not None, name
    controller = weights.controller
    compile_together(*replan_jobs(task, controller))
    found = []
    for seed in options.seeds:
        key = jax.random.key(seed)
        count = max(options.starts, tries(task))
        states = start_states(task.problem, key, count=-(-count // tries(task)) * tries(task))
        pushes = Pushes(size, robot_of(scene).workspace.arena, options.pushes, seed)
        found.append(withstand(task, controller, states[: options.starts], pushes))
    return found


def row(name: str, size: float, found: list[Withstood]) -> str:
    """A line of the table."""

    def rate(rows: list[np.ndarray]) -> str:
        each = [float(np.mean(row)) for row in rows]
        return f"{np.mean(each):.2f} ± {np.std(each):.2f}"

    seconds = np.concatenate([one.seconds for one in found])
    cells = (
        name,
        f"{size:g}",
        rate([one.undisturbed >= 0 for one in found]),
        rate([one.as_planned >= 0 for one in found]),
        rate([one.anew >= 0 for one in found]),
        rate([one.hopeless for one in found]),
        f"{np.median(seconds):.2f} / {np.quantile(seconds, 0.95):.2f}",
    )
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robots", nargs="*", default=list(ENVS), metavar="ROBOT")
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--starts", type=int, default=32)
    parser.add_argument(
        "--sizes", type=float, nargs="+", default=[1.5, 4.0], help="in robot lengths"
    )
    parser.add_argument("--pushes", type=int, default=1)
    parser.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2])
    options = parser.parse_args()
    unknown = sorted(set(options.robots) - set(ENVS))
    if unknown:
        parser.error(f"unknown robots: {', '.join(unknown)}. Available: {', '.join(ENVS)}")
    use_disk_cache()
    print(
        f"{platform.system()} {platform.machine()}, {os.cpu_count()} CPU cores, load "
        f"{os.getloadavg()[0]:.1f}, JAX {jax.__version__} on {jax.default_backend()}, "
        f"{time.strftime('%Y-%m-%d')}; {options.starts} starts a seed, seeds {options.seeds}, "
        f"{options.pushes} push(es) an episode\n"
    )
    print("| " + " | ".join(COLUMNS) + " |")
    print("| --- " * len(COLUMNS) + "|")
    for robot in options.robots:
        for number in options.tasks:
            for size in options.sizes:
                name, metres = f"{robot}-{number}", size * ENVS[robot].length
                print(row(name, metres, measured(name, metres, options)), flush=True)


if __name__ == "__main__":
    main()
