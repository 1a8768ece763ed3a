"""Find the most robust plan that time allows for each Linear task, and keep it as a witness.

Development tool, not part of the test run: `python -m tests.tools.find_linear_witness [TASK ...]`.
Prints a Markdown table with the bound that is proved; rtamt judges the plans.
"""

import sys

import numpy as np

from core.planning.exact import plan_exactly
from scenes import load_task, scene_formula, task_names
from scenes.outlines import setting_of
from studio.runs.exact import replayed
from tests.tools.witness import judge, save_witness

SECONDS = 60.0
"""Of search, per task."""


def main(tasks: list[str]) -> None:
    """Plan, judge and store."""
    print("| task | status | robustness [m] | bound [m] | seconds |\n|---|---|---|---|---|")
    for task in tasks or task_names("linear"):
        scene = load_task(task)
        found = plan_exactly(scene_formula(scene), setting_of(scene), seconds=SECONDS)
        value = -np.inf
        if found.positions is not None:
            plan = replayed(scene, scene_formula(scene), found)
            value = judge(scene, found.positions[0], plan["actions"])
            save_witness(task, found.positions[0], plan["actions"], 1)
        row = (task, found.status, f"{value:.3f}", f"{found.bound:.3f}", f"{found.seconds:.0f}")
        print(f"| {' | '.join(row)} |", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
