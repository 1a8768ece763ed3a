"""Showing other tasks keeps no more compiled programs."""

import jax
import pytest

from envs import ENVS
from scenes import load_task
from studio.runs.tasks import build_task, initial_state


@pytest.mark.parametrize("robot", sorted(ENVS))
def test_initial_states_of_a_robot_share_one_program(robot):
    """The panda's inverse kinematics, not compiled as a whole, kept a program for each call."""
    task = build_task(load_task(f"{robot}-demo"))
    size = task.problem.data.initial_low.size
    initial_state(task)
    initial_state(task, (0.3,) * size)
    before = len(jax.devices()[0].client.live_executables())
    for shift in range(3):
        initial_state(task, (0.3 + 0.01 * shift,) * size)
    assert len(jax.devices()[0].client.live_executables()) == before
