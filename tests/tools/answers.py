"""What a robot's weights reach without training, on tasks that they were not trained on.

    python -m tests.tools.answers linear --missions 60 --layouts 3
    python -m tests.tools.answers ant --weights runs/w/weights.safetensors --starts 8

For each set of tasks: how many are solved (from at least 90 % of the starts) by the critic's one
choice, by the best of several simulated schedules, and by whole answers; and how long an answer
takes. Prints a Markdown table. Run it on a machine that does nothing else.
"""

import argparse
import platform
import time
from collections.abc import Iterator

import jax
import numpy as np

from core.answer import THOROUGH
from core.compilation import use_disk_cache
from core.task.task import Task
from scenes import load_task
from scenes.missions import HELD_OUT, SHIPPED_HELD_OUT, SHIPPED_TRAINED
from studio.runs.held_out import GOOD, rates, summary
from studio.runs.missions import ShippedMissions, mission
from studio.runs.pretrained import chosen_weights
from studio.runs.tasks import build_task

SEED = 2**22
"""First seed of the missions; neither training nor cards use them."""


COLUMNS = (
    *("set", "tasks", "one choice >= 0.9", "simulated >= 0.9", "answered >= 0.9"),
    *("one choice, mean", "simulated, mean", "answer, median / p95 [s]"),
)


def sets(robot: str, missions: int, layouts: int) -> Iterator[tuple[str, list[Task]]]:
    """Names of sets, and their tasks."""
    formulas = [build_task(load_task(f"{robot}-{number}")) for number in SHIPPED_HELD_OUT]
    yield "shipped, formula held out", formulas
    for family in HELD_OUT:
        count = missions // len(HELD_OUT)
        yield (
            f"random, {family} (held out)",
            [mission(robot, family, SEED + number).task for number in range(count)],
        )
    for name, numbers in (
        ("formula trained", SHIPPED_TRAINED),
        ("formula held out", ("05", "09", "10")),
    ):
        source = ShippedMissions(robot, SEED, numbers)
        yield (
            f"perturbed, {name}",
            [source(number).task for number in range(layouts * len(numbers))],
        )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot")
    parser.add_argument("--weights", default="shipped")
    parser.add_argument("--missions", type=int, default=60)
    parser.add_argument("--layouts", type=int, default=2, help="perturbed layouts of each task")
    parser.add_argument("--states", type=int, default=512, help="for the one choice")
    parser.add_argument("--starts", type=int, default=16, help="for the simulated one")
    options = parser.parse_args()
    use_disk_cache()
    task = build_task(load_task(f"{options.robot}-08"))
    weights = chosen_weights(options.weights, task)
    if weights is None:
        parser.error(f"there are no weights for {options.robot}")
    card, system = weights.card, f"{platform.system()} {platform.machine()}"
    print(
        f"{system}, JAX {jax.__version__} on {jax.default_backend()}, {time.strftime('%Y-%m-%d')}"
    )
    print(f"{card.robot}, seed {card.seed}, {card.epochs} epochs in {card.train_seconds:.0f} s\n")
    print("| " + " | ".join(COLUMNS) + " |")
    print("| --- " * len(COLUMNS) + "|")
    for name, tasks in sets(options.robot, options.missions, options.layouts):
        found = [
            rates(
                one,
                weights.controller,
                states=options.states,
                starts=options.starts,
                effort=THOROUGH,
            )
            for one in tasks
        ]
        row = summary(name, found)
        answered = sum(each.answered >= GOOD for each in found)
        seconds = np.concatenate([each.seconds for each in found])
        print(
            f"| {name} | {row.tasks} | {row.chosen} | {row.simulated} | {answered} | "
            f"{row.chosen_mean:.3f} | {row.simulated_mean:.3f} | "
            f"{np.median(seconds):.2f} / {np.quantile(seconds, 0.95):.2f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
