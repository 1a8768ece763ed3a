from dataclasses import replace

import pytest

from core.training import TrainingConfig, final_evaluation
from scenes import load_task
from studio.files.shipped import SHIPPED, shipped_policy
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


def test_an_edited_scene_has_no_shipped_policy(linear_task):
    scene = load_task("linear-08")
    assert shipped_policy(replace(scene, formula="F_[0:90](A1)"), linear_task) is None
    assert shipped_policy(load_task("linear-07"), linear_task) is None
