"""Shipped tasks as Gymnasium environments."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from core.errors import UserError
from scenes import demo_names, load_task, robot_of, task_names
from studio.gym import registration
from studio.gym.environment import BROKEN, StlEnv
from tests.scenes.geometry import margins_table
from tests.scenes.oracle import rtamt_robustness
from tests.tools.witness import load_witness


@pytest.fixture(scope="module")
def env(disk_cache):
    return StlEnv("linear-demo")


def played(env, actions, **how):
    """Observations [T + 1, ...], rewards [T] and the last `info` of an episode."""
    observed, _ = env.reset(**how)
    seen, paid, info = [observed], [], {}
    for action in actions:
        observed, reward, terminated, truncated, info = env.step(action)
        seen.append(observed)
        paid.append(reward)
        assert not truncated
        if terminated:
            break
    return np.array(seen), np.array(paid), info


@pytest.mark.filterwarnings("ignore:.*A Box observation space m.*:UserWarning")
@pytest.mark.filterwarnings("ignore:.*alternative render modes.*:UserWarning")
def test_gymnasium_s_own_check(env):
    check_env(env)


def test_all_shipped_tasks_have_an_identifier():
    assert registration.shipped() == sorted(task_names() + demo_names())
    registration.register()
    spec = gymnasium.spec("tgpo/linear-08-v0")
    assert spec.kwargs == {"task": "linear-08"}
    assert spec.max_episode_steps is None


def test_what_is_observed(env):
    scene, steps = load_task("linear-demo"), env.task.horizon
    actions = np.random.default_rng(3).uniform(-1, 1, (steps, 2)).astype(np.float32)
    seen, _, _ = played(env, actions, seed=5)
    positions, over, margins = seen[:, :2], seen[:, 2], seen[:, 3:]
    assert over == pytest.approx(np.arange(steps + 1) / steps)
    assert margins == pytest.approx(margins_table(scene, positions), abs=1e-5)
    stride = np.array(robot_of(scene).stride)  # pyright: ignore
    assert np.diff(positions, axis=0) == pytest.approx(actions * stride, abs=1e-5)


@pytest.mark.parametrize("seed", [1, 2])
def test_the_last_step_pays_the_robustness(env, seed):
    scene = load_task("linear-demo")
    actions = np.random.default_rng(seed).uniform(-1, 1, (env.task.horizon, 2))
    seen, paid, info = played(env, actions, seed=seed)
    assert len(paid) == env.task.horizon and not paid[:-1].any()
    table = margins_table(scene, seen[:, :2])
    expected = rtamt_robustness(scene.formula, scene.region_names, table)
    assert paid[-1] == pytest.approx(expected, abs=1e-5)
    assert info == {"robustness": paid[-1], "satisfied": paid[-1] >= 0}


def test_a_plan_that_is_known_to_succeed_is_paid(env):
    witness = load_witness("linear-demo")
    how = {"options": {"position": witness.initial}}
    _, paid, info = played(env, witness.actions[: env.task.horizon], **how)
    assert paid[-1] >= 0 and info["satisfied"]


def test_a_seed_gives_an_episode(env):
    actions = np.full((env.task.horizon, 2), 0.3)
    one, other = (played(env, actions, seed=7)[0] for _ in range(2))
    assert np.array_equal(one, other)
    assert not np.array_equal(one[0], played(env, actions[:1], seed=8)[0][0])


def test_another_formula_has_its_own_horizon(disk_cache):
    env = StlEnv("linear-demo", formula="F_[0:5](A1 | !A1) & G_[0:90](!B)")
    assert env.task.horizon == max(load_task("linear-demo").horizon, 90)


def test_true_physics_and_a_simulation_that_breaks_down(disk_cache, monkeypatch):
    env = StlEnv("ant-demo")
    seen, _, _ = played(env, np.zeros((2, 2)), seed=0)
    assert seen.shape == (3, *env.observation_space.shape)  # pyright: ignore
    assert np.abs(seen[2, :2] - seen[0, :2]).max() < 0.2

    class Breaking:
        def step(self, states, actions):
            return np.full_like(states, np.nan)

    env.reset(seed=0)
    monkeypatch.setattr(env, "_physics", Breaking())
    observed, reward, terminated, _, info = env.step(np.zeros(2))
    assert terminated and reward == BROKEN * env.task.robot.length
    assert info == {"robustness": -np.inf, "satisfied": False}
    assert env.observation_space.contains(observed)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "give either a task"),
        ({"task": "linear-99"}, "task: unknown 'linear-99'"),
        ({"task": "linear-demo", "formula": "F_[0:5](Z)"}, "Z"),
    ],
)
def test_what_cannot_be_made_is_refused(given, message):
    with pytest.raises(UserError, match=message):
        StlEnv(**given)


@pytest.mark.parametrize("options", [{"speed": 3}, {"position": (1, 2, 3)}, {"position": "x"}])
def test_wrong_options_are_refused(env, options):
    with pytest.raises(UserError, match="options: "):
        env.reset(options=options)
