"""How well the critic of a robot's weights ranks schedules of missions never trained on.

    python -m tests.tools.ranking linear --missions 60
    python -m tests.tools.ranking ant --missions 12 --schedules 64

On each mission, schedules that leave time to travel are carried out from one random start. Where 5
to 95 % of them satisfy the formula: the area under the ROC curve of the critic's value against the
exact verdict. Where more do: Spearman's rank correlation of value and exact robustness.
"""

import argparse
import time

import jax
import jax.numpy as jnp
import numpy as np

from core.attempts import tries
from core.candidates import scored_schedules
from core.compilation import use_disk_cache
from core.controller import Controller
from core.evaluation import trace_robustness
from core.rollout import roll_out, start_states
from core.task.task import Task
from core.truth import ranks, spearman
from scenes import load_task
from scenes.missions import HELD_OUT
from studio.runs.missions import mission
from studio.runs.pretrained import chosen_weights
from studio.runs.tasks import build_task
from tests.tools.answers import SEED

FEW, MOST = 0.05, 0.95
"""Shares of satisfying schedules between which a ranking can be right or wrong."""


def ranked(
    task: Task, controller: Controller, number: int, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Values and exact robustness [count] of schedules from one random start."""
    state_key, draw_key = jax.random.split(jax.random.fold_in(jax.random.key(2), number))
    batch = tries(task)
    state = start_states(task.problem, state_key, count=batch)[0]
    states = jnp.broadcast_to(state, (batch, *state.shape))
    values, margins = [], []
    for key in jax.random.split(draw_key, -(-count // batch)):
        schedules, scores = scored_schedules(task.problem, controller, key, states)
        rollout = roll_out(task, controller, states, schedules)
        values.append(np.asarray(scores))
        margins.append(trace_robustness(task, np.asarray(rollout.margins)))
    return np.concatenate(values)[:count], np.concatenate(margins)[:count]


def area(values: np.ndarray, satisfied: np.ndarray) -> float:
    """Chance that a schedule that satisfies is valued above one that does not; ties count half."""
    positives = int(satisfied.sum())
    above = ranks(values)[satisfied].sum() - positives * (positives + 1) / 2
    return float(above / positives / (satisfied.size - positives))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("robot")
    parser.add_argument("--weights", default="shipped")
    parser.add_argument("--missions", type=int, default=60)
    parser.add_argument("--schedules", type=int, default=256)
    options = parser.parse_args()
    use_disk_cache()
    weights = chosen_weights(options.weights, build_task(load_task(f"{options.robot}-08")))
    if weights is None:
        parser.error(f"there are no weights for {options.robot}")
    areas, correlations, none = [], [], 0
    for number in range(options.missions):
        family = HELD_OUT[number % len(HELD_OUT)]
        task = mission(options.robot, family, SEED + 500 + number).task
        values, robustness = ranked(task, weights.controller, number, options.schedules)
        share = float((robustness >= 0).mean())
        if FEW <= share <= MOST:
            areas.append(area(values, robustness >= 0))
        elif share > MOST:
            correlations.append(spearman(values, robustness))
        else:
            none += 1
    print(
        f"{time.strftime('%Y-%m-%d')}: {options.robot}, {options.missions} missions of held-out "
        f"families, {options.schedules} schedules each, from one start each\n"
        f"AUC, {len(areas)} missions with 5 to 95 %: {_spread(areas)}\n"
        f"Spearman, {len(correlations)} missions with more: {_spread(correlations)}\n"
        f"missions with less than 5 %: {none}"
    )


def _spread(values: list[float]) -> str:
    values = [each for each in values if not np.isnan(each)]  # all schedules alike
    if not values:
        return "-"
    quarters = np.quantile(values, [0.25, 0.5, 0.75])
    return f"mean {np.mean(values):.3f}, quartiles {' '.join(f'{each:.3f}' for each in quarters)}"


if __name__ == "__main__":
    main()
