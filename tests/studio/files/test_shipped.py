from dataclasses import replace

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.grounding import MAX_VARIABLES
from core.heatmap import heatmap
from core.programs import evaluation_programs
from core.training import TrainingConfig, final_evaluation
from scenes import demo_names, load_task
from studio.analyst import ROLLOUTS, initial_state
from studio.files.shipped import SHIPPED, shipped_policy
from studio.playing.recording import record
from studio.tasks import build_task


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_policy_solves_its_task(name, disk_cache):
    scene = load_task(name)
    task = build_task(scene)
    policy = shipped_policy(scene, task)
    assert policy is not None
    config = TrainingConfig(policy.algorithm, seed=2)
    evaluation = final_evaluation(task, config, policy.parameters)
    assert len(evaluation.robustness) == 512
    assert evaluation.success_rate >= 0.97


@pytest.mark.parametrize("name", [name for name in SHIPPED if name in demo_names()])
def test_a_demo_reaches_its_goals_in_either_order(name, disk_cache):
    """From random starts, with the schedule of each order that the critic likes best."""
    scene = load_task(name)
    task = build_task(scene)
    policy = shipped_policy(scene, task)
    assert policy is not None
    asked = (task, policy.algorithm, policy.parameters)
    nothing = np.zeros(MAX_VARIABLES, np.int32)
    drawn = heatmap(*asked, initial_state(task), nothing, (0, 1))
    score = policy.algorithm.preference(drawn.values, drawn.shortfall)
    programs = evaluation_programs(task, policy.algorithm, rollouts=ROLLOUTS)
    states = programs.initial(task.problem, jax.random.key(3))
    cells = {
        (row, column): drawn.schedule_at(row, column) for row, column in np.ndindex(score.shape)
    }
    for first, second in ((0, 1), (1, 0)):
        best = max(
            (cell for cell, times in cells.items() if times[first] < times[second]),
            key=lambda cell: np.nan_to_num(score[cell], nan=-np.inf),
        )
        schedules = jnp.tile(jnp.asarray(cells[best]), (ROLLOUTS, 1))
        rollout = programs.roll_out(task.problem, policy.parameters, states, schedules)
        visited, actions, margins = (np.asarray(trace) for trace in rollout[:3])
        verdicts = [
            record(task, cells[best], visited[:, i], actions[:, i], margins[:, i]).satisfied
            for i in range(ROLLOUTS)
        ]
        assert sum(verdicts) >= 0.9 * ROLLOUTS, (first, cells[best])


def test_an_edited_scene_has_no_shipped_policy(linear_task):
    scene = load_task("linear-08")
    assert shipped_policy(replace(scene, formula="F_[0:90](A1)"), linear_task) is None
    assert shipped_policy(load_task("linear-07"), linear_task) is None
