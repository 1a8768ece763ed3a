"""What a critic's scores are worth: against the robustness of what they promise, and as a map.

As in the paper's App. A.6 and Fig. 5. Dimensions: R rollouts of one program, V variables.
"""

from typing import Any

import jax
import numpy as np

from core.candidates import choose_schedules, ranked, scored_schedules
from core.controller import Controller
from core.evaluation import EVALUATION_STATES, rollout_robustness
from core.heatmap import heatmap
from core.rollout import roll_out, start_states
from core.task.protocols import Array
from core.task.task import Task
from studio.runs.tasks import initial_state


def critic_samples(task: Task, controller: Controller, key: Array, count: int) -> dict[str, Any]:
    """Scores and robustness [m] of so many random schedules, each from a random initial state.

    Schedules are drawn as those that the controller chooses from. A trace that broke down has no
    robustness and is left out.
    """
    scores, values = [], []
    for batch in jax.random.split(key, -(-count // EVALUATION_STATES)):
        start_key, draw_key = jax.random.split(batch)
        states = start_states(task.problem, start_key, count=EVALUATION_STATES)
        schedules, score = scored_schedules(task.problem, controller, draw_key, states)
        values.append(rollout_robustness(task, roll_out(task, controller, states, schedules)))
        scores.append(np.asarray(score))
    score, value = np.concatenate(scores)[:count], np.concatenate(values)[:count]
    sound = np.isfinite(score) & np.isfinite(value)
    return {"critic_scores": score[sound].tolist(), "critic_robustness": value[sound].tolist()}


def critic_map(task: Task, controller: Controller, key: Array) -> dict[str, Any]:
    """Scores over the first two variables from the middle of the initial set; none without them.

    The other variables are those of the controller's choice; cells whose legs are too short have
    no score.
    """
    if int(task.problem.formula.variables) < 2:
        return {}
    middle = initial_state(task)
    choice = ranked(task.problem, controller, key, middle).schedules[0]
    found = heatmap(task, controller, middle, choice, (0, 1))
    shown = np.where(found.shortfall > 0, np.nan, found.values)
    return {
        "critic_map": {
            "first": found.first.tolist(),
            "second": found.second.tolist(),
            "scores": shown.ravel().tolist(),
        }
    }


def middle_robustness(task: Task, controller: Controller, key: Array) -> float:
    """Mean robustness [m] of the controller's choices from the middle of the initial set."""
    states = np.repeat(np.asarray(initial_state(task))[None], EVALUATION_STATES, axis=0)
    given = jax.numpy.asarray(states)
    schedules, _ = choose_schedules(task.problem, controller, key, given)
    best = rollout_robustness(task, roll_out(task, controller, given, schedules))
    for attempt in controller.attempts[1:]:
        again = rollout_robustness(task, roll_out(task, attempt, given, schedules))
        best = np.maximum(best, again)
    return float(best.mean())
