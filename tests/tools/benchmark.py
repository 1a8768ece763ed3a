"""What `tgpo-bench` does not measure: compilation in fresh processes, and layouts never trained on.

    python -m tests.tools.benchmark compile
    python -m tests.tools.benchmark layouts --tasks linear-08 quadrotor-08 --epochs 150

Prints Markdown tables. Run it on a machine that does nothing else.
"""

import argparse
import json
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path

import jax

from core.compilation import use_disk_cache
from core.methods.tgpo.algorithm import make_algorithm, many_layouts
from core.methods.training import TrainingConfig, final_evaluation, train
from scenes import load_task, robot_of, task_names
from studio.runs.layouts import held_out, randomized
from studio.runs.tasks import build_task

HELD_OUT = 10
"""Layouts on which transfer is measured."""


def _row(*cells: object) -> None:
    print("| " + " | ".join(str(cell) for cell in cells) + " |", flush=True)


def _header(*names: str) -> None:
    _row(*names)
    _row(*["---"] * len(names))


def _expand(names: Iterable[str]) -> list[str]:
    """Robots stand for all their tasks."""
    tasks = task_names()
    return [t for name in names for t in tasks if t in (name, f"{name}-{t.rsplit('-', 1)[1]}")]


_FIRST_RUN = """
import json, sys, time
began = time.perf_counter()
from pathlib import Path
from core.compilation import use_disk_cache
use_disk_cache(Path(sys.argv[1]))
from core.methods.tgpo.algorithm import make_algorithm
from core.methods.training import TrainingConfig, train
from envs import Linear
from scenes import load_task
from studio.runs.tasks import build_task
imported = time.perf_counter()
config = TrainingConfig(make_algorithm("studio", "tgpo-star", Linear()), epochs=3,
                        evaluate_every=9)
seconds = {}
first = list(train(build_task(load_task("linear-08")), config))
seconds["compile"] = first[-1].compile_seconds
epoch = first[-1].train_seconds / 3
start = time.perf_counter()
next(iter(train(build_task(load_task("linear-10")), config)))
seconds["further"] = time.perf_counter() - start
seconds["epoch"] = epoch
seconds["import"] = imported - began
print(json.dumps(seconds))
"""


def benchmark_compilation(repeats: int) -> None:
    """Compilation in fresh processes: with an empty disk cache, then with a filled one."""
    print()
    _header("process", "import [s]", "compile [s]", "an epoch [s]", "further formula [s]")
    for _ in range(repeats):
        with tempfile.TemporaryDirectory() as cache:
            for name in ("first ever", "disk cache"):
                command = [sys.executable, "-c", _FIRST_RUN, cache]
                result = subprocess.run(command, capture_output=True, text=True, check=True)
                s = json.loads(result.stdout.splitlines()[-1])
                _row(
                    name,
                    f"{s['import']:.1f}",
                    f"{s['compile']:.1f}",
                    f"{s['epoch']:.2f}",
                    f"{s['further']:.2f} (build, first epoch)",
                )


def benchmark_layouts(tasks: list[str], seeds: list[int], epochs: int) -> None:
    """Zero-shot success on ten layouts never trained on, with and without `--randomize`."""
    print(f"\nSuccess on the task's own layout and on {HELD_OUT} held-out ones, nothing trained.\n")
    names = ("epochs", "seconds", "own layout", "held out, mean", "each")
    _header("task", "seed", "trained on", *names)
    for name in tasks:
        scene = load_task(name)
        plain = make_algorithm("studio", "tgpo-star", robot_of(scene))
        one = build_task(scene)
        tests = list(held_out(scene, one, plain, HELD_OUT))
        for seed in seeds:
            for algorithm in (plain, many_layouts(plain)):
                config = TrainingConfig(algorithm, seed=seed, epochs=epochs)
                *_, last = train(randomized(scene, one, algorithm, seed), config)
                own, *rates = (
                    final_evaluation(task, config, last.state.best).success_rate
                    for task in (one, *tests)
                )
                _row(
                    name,
                    seed,
                    "its own layout" if algorithm is plain else "many layouts",
                    last.epoch,
                    f"{last.train_seconds:.0f}",
                    f"{own:.3f}",
                    f"{statistics.mean(rates):.3f}",
                    " ".join(f"{rate:.2f}" for rate in sorted(rates)),
                )


def main() -> None:
    """Parse the command line and run one benchmark."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("what", choices=("compile", "layouts"))
    parser.add_argument("--tasks", nargs="+", default=["linear", "unicycle"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1007, 1008, 1009])
    parser.add_argument("--epochs", type=int, default=80)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    print(f"{platform.system()} {platform.machine()}, Python {platform.python_version()}, ", end="")
    print(f"JAX {jax.__version__} on {jax.default_backend()}, {time.strftime('%Y-%m-%d')}")
    if options.what == "compile":
        benchmark_compilation(options.repeats)
        return
    cache = Path(tempfile.gettempdir()) / "tgpo-studio-benchmark-cache"
    use_disk_cache(cache)
    benchmark_layouts(_expand(options.tasks), options.seeds, options.epochs)


if __name__ == "__main__":
    main()
