"""Every shipped task can be carried out: a stored plan does it in the robot, says rtamt."""

import jax
import numpy as np
import pytest

from envs import ENVS
from scenes import demo_names, load_task, region_arrays, task_names
from scenes.margins import margins
from tests.scenes.geometry import margin
from tests.scenes.oracle import rtamt_robustness
from tests.tools.find_ant_witness import judge_walk
from tests.tools.witness import episode_length, load_witness


def _trace(robot, arrays, initial, actions):
    """Positions [T + 1, d] and margins [T + 1, A] of a rollout in the robot itself."""

    def advance(state, action):
        following = robot.step(state, action)
        return following, following

    _, states = jax.lax.scan(advance, initial, actions)
    positions = robot.position(jax.numpy.concatenate([initial[None], states]))
    return positions, jax.vmap(margins, (None, 0))(arrays, positions)


REPLAY = jax.jit(_trace, static_argnums=0)


PLANNED = [name for name in task_names() + demo_names() if not name.startswith("ant-")]
"""Tasks whose witnesses are actions; the ant's are waypoints in the world."""


@pytest.mark.parametrize("task", PLANNED)
def test_the_stored_plan_carries_out_the_task(task):
    scene = load_task(task)
    robot = ENVS[scene.robot]
    witness = load_witness(task)
    length = episode_length(scene)
    padding = np.zeros((120 - len(witness.actions), robot.action_size))
    actions = np.concatenate([witness.actions, padding]).astype(np.float32)
    arrays = region_arrays(scene.regions, scene.dimension, 32)
    initial = witness.initial.astype(np.float32)
    positions, table = REPLAY(robot, arrays, initial, actions)

    assert len(witness.actions) >= length
    assert np.abs(witness.actions).max() <= 1.0
    assert margin(scene.initial, positions[0]) >= 0
    table = np.asarray(table)[: length + 1, : len(scene.regions)]
    assert rtamt_robustness(scene.formula, scene.region_names, table) >= 0


@pytest.mark.parametrize("task", task_names() + demo_names())
def test_standing_still_does_not(task):
    scene = load_task(task)
    position = np.array(scene.initial.center)
    row = [margin(region, position) for region in scene.regions]
    table = np.tile(row, (episode_length(scene) + 1, 1))
    assert rtamt_robustness(scene.formula, scene.region_names, table) < 0


@pytest.mark.parametrize("task", [*task_names("ant"), *demo_names("ant")])
def test_stored_waypoints_lead_the_ant_through_the_task(task):
    scene = load_task(task)
    witness = load_witness(task)
    length = episode_length(scene)
    assert margin(scene.initial, witness.initial[:2]) >= 0
    assert judge_walk(scene, witness.initial, witness.actions[:length]) >= 0
