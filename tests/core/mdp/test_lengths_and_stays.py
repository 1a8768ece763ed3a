"""Lengths in the robot's unit, stays that are paid step by step, and starts within stays."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.mdp.grounded import ground_schedule
from core.mdp.mode import advance, begin, first_views
from core.mdp.paper_mode import PaperMode
from core.mdp.studio_mode import StudioMode
from core.methods.tgpo.algorithm import make_algorithm
from core.methods.tgpo.collection import _following_starts
from core.task.protocols import Tuning
from tests.core.toy import CENTERS, PointRobot, toy_task

STAY = "F_[2:9](G_[0:4](A)) & F_[0:14](B) & G_[0:14](!C)"
SCHEDULES = jnp.array([[5, 14] + [0] * 6, [2, 11] + [0] * 6], jnp.int32)


def _scaled(task, factor: float):
    """The same task with all lengths times a factor."""
    problem = task.problem
    return replace(
        problem,
        robot=PointRobot(speed=0.5 * factor, length=factor),
        data=jax.tree.map(lambda leaf: leaf * factor, problem.data),
        inside=problem.inside * factor,
        center=problem.center * factor,
        legs=problem.legs * factor,
    )


def _episode(mode, factor, actions, schedule):
    return _run(mode, _scaled(toy_task(STAY), factor), actions, schedule)


@partial(jax.jit, static_argnums=0)
def _run(mode, problem, actions, schedule):
    state = jnp.zeros(2)
    mdp = ground_schedule(problem, state, schedule, reserve=1.2)
    view = begin(mode, mdp, state, jnp.float32(0))

    def step(carry, action):
        moved = problem.robot.step(carry.episode.state, action)
        after, reward, ends = advance(mode, mdp, carry, moved)
        return after, (after.policy, after.critic, reward, ends)

    return jax.lax.scan(step, view, actions)[1]


@pytest.mark.parametrize("mode", [StudioMode(), PaperMode()], ids=["studio", "paper"])
def test_a_small_robot_in_a_small_world_sees_and_earns_the_same(mode):
    actions = jnp.asarray(np.random.default_rng(0).uniform(-1, 1, (15, 2)), jnp.float32)
    normal = _episode(mode, 1.0, actions, SCHEDULES[0])
    small = _episode(mode, 0.2, actions, SCHEDULES[0])
    for expected, found in zip(normal, small, strict=True):
        np.testing.assert_allclose(found, expected, atol=2e-4)


def test_gradual_stays_pay_their_share_a_step_and_the_same_in_all():
    towards = np.asarray(CENTERS["A"]) / 0.5
    actions = np.zeros((9, 2), np.float32)
    actions[:4] = towards / 4  # arrives in A after four steps and stays for steps 5 to 9
    modes = [StudioMode(scale=1.0, shape=0.0, gradual_stays=gradual) for gradual in (False, True)]
    whole, shared = (_episode(mode, 1.0, jnp.asarray(actions), SCHEDULES[0])[2] for mode in modes)
    np.testing.assert_allclose(whole, [0] * 8 + [20.0], atol=1e-5)
    np.testing.assert_allclose(shared, [0] * 4 + [4.0] * 5, atol=1e-5)


def test_nothing_is_paid_for_a_stay_that_is_missed():
    mode = StudioMode(scale=1.0, shape=0.0, gradual_stays=True)
    rewards = _episode(mode, 1.0, jnp.zeros((9, 2)), SCHEDULES[0])[2]
    np.testing.assert_allclose(rewards, 0.0, atol=1e-6)


@pytest.mark.parametrize("gradual", [False, True])
def test_exploring_starts_lie_at_completions_or_within_stays(gradual):
    task = toy_task(STAY)
    mode = StudioMode(exploring=1.0, gradual_stays=gradual)
    count = 400
    states = jnp.zeros((count, 2))
    schedules = jnp.repeat(SCHEDULES[:1], count, axis=0)

    @jax.jit
    def following(key):
        mdps, _ = first_views(mode, task.problem, states, schedules, 1.2)
        return _following_starts(task.problem, mode, mdps, key, states)

    found = set(np.asarray(following(jax.random.key(0)).episode.tau).astype(int))
    assert found == ({0, 5, 6, 7, 8, 9} if gradual else {9})


@pytest.mark.parametrize("gradual", [True, False])
def test_they_are_the_robots_wish_and_not_the_papers(gradual):
    robot = PointRobot(tuning=Tuning(gradual_stays=gradual))
    assert make_algorithm("studio", "tgpo-star", robot).mode.gradual_stays == gradual
    assert not make_algorithm("paper", "tgpo-star", robot).mode.gradual_stays
