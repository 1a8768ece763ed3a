"""Lengths in the robot's unit, stays that are paid step by step, and starts within stays."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.algorithm import Algorithm, make_algorithm
from core.collection import _start_pool
from core.paper_mode import PaperMode
from core.rollout import Setting, advance, begin, ground_schedule
from core.studio_mode import StudioMode
from tests.core.toy import CENTERS, DiscWorld, PointRobot, toy_task

STAY = "F_[2:9](G_[0:4](A)) & F_[0:14](B) & G_[0:14](!C)"
SCHEDULES = jnp.array([[5, 14] + [0] * 6, [2, 11] + [0] * 6], jnp.int32)


def _scaled(task, factor: float):
    """The same task with all lengths times a factor."""
    problem = task.problem
    return problem._replace(
        world=jax.tree.map(lambda leaf: leaf * factor, problem.world),
        inside=problem.inside * factor,
        center=problem.center * factor,
        legs=problem.legs * factor,
    )


def _episode(mode, factor, actions, schedule):
    task = toy_task(STAY)
    problem = _scaled(task, factor)
    robot = PointRobot(speed=0.5 * factor, length=factor)
    setting = Setting(robot, DiscWorld(), Algorithm(mode=mode), task.horizon)
    state = jnp.zeros(2)
    grounded = ground_schedule(setting, problem, state, schedule)
    view = begin(setting, problem, grounded, state, jnp.float32(0))

    def step(carry, action):
        after, reward, ends = advance(setting, problem, grounded, carry, action)
        return after, (after.policy, after.critic, reward, ends)

    return jax.jit(lambda: jax.lax.scan(step, view, actions))()[1]


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
    setting = Setting(PointRobot(), DiscWorld(), Algorithm(mode=mode), task.horizon)
    count = 400
    states = jnp.zeros((count, 2))
    schedules = jnp.repeat(SCHEDULES[:1], count, axis=0)
    grounded = jax.vmap(ground_schedule, (None, None, 0, 0))(
        setting, task.problem, states, schedules
    )
    pool = _start_pool(setting, task.problem, grounded, jax.random.key(0), states)
    tau = np.asarray(pool.episode.tau)
    assert (tau[:count] == 0).all()
    found = set(tau[count:].astype(int))
    assert found == ({0, 5, 6, 7, 8, 9} if gradual else {9})


def test_only_the_quadrotor_asks_for_them():
    for robot, gradual in {"linear": False, "unicycle": False, "quadrotor": True}.items():
        mode = make_algorithm("studio", "tgpo-star", robot).mode
        assert mode.gradual_stays == gradual
    assert not make_algorithm("paper", "tgpo-star", "quadrotor").mode.gradual_stays
