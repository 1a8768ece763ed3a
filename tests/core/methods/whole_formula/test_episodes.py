"""Whole episodes: what is paid when, where they end, and that learning sees what acting saw."""

from dataclasses import dataclass, replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.methods import METHODS
from core.methods.recurrent_ppo import RecurrentPolicy
from core.methods.whole_formula.episodes import explore, reward_of, verdicts
from core.methods.whole_formula.learner import LearnerState, update
from tests.core.toy import PointRobot, toy_task

COUNT, STEPS = 6, 16
FORMULA = "F_[1:4](F_[0:6](A) & G_[2:6](!B))"


@dataclass(frozen=True)
class Bursting(PointRobot):
    """Breaks down once it has gone to the right."""

    name: str = "bursting"

    def step(self, state, action):
        after = super().step(state, action)
        return jnp.where(after[0] > 0.8, jnp.nan, after)


def explored(method: str, task):
    algorithm = replace(METHODS[method].preset("studio", PointRobot()), hidden=(8,))
    learner: Any = METHODS[method].learner(task, algorithm)
    state = learner.fresh(0)
    episodes = explore(
        task.problem, state.weights, jax.random.key(3), policy=learner.policy, count=COUNT,
        steps=STEPS,
    )  # fmt: skip
    return learner.policy, state, episodes


def test_a_step_is_paid_for_where_it_leads():
    """What is paid for step k is the rise of the flags from state k to state k + 1."""
    task = toy_task(FORMULA)
    _, state, episodes = explored("f-mdp", task)
    data = state.weights.memory
    share = np.asarray(episodes.seen)[..., -data.width.size :]
    met = np.where(data.always, share, share > 0).sum(-1) / 2  # [L + 1, N]
    np.testing.assert_allclose(episodes.paid, np.diff(met, axis=0), atol=1e-6)
    assert np.abs(episodes.paid).sum() > 0.5


@pytest.mark.parametrize("horizon", [16, 11])
def test_robustness_is_paid_once_at_the_end(horizon):
    """Whatever is simulated beyond the horizon does not count."""

    class Spy:
        def learn(self, algorithm, weights, optimizer, transitions, key):
            return transitions, None

    _, state, episodes = explored("f-mdp", toy_task(FORMULA))
    final = jnp.arange(1.0, COUNT + 1)
    found: Any = update(
        LearnerState(state.weights, None, state.key),
        episodes,
        final,
        jnp.int32(horizon),
        policy=Spy(),  # pyright: ignore[reportArgumentType]
        algorithm=None,  # pyright: ignore[reportArgumentType]
    ).weights
    added = np.asarray(found.reward) - np.asarray(episodes.paid)
    np.testing.assert_allclose(added[horizon - 1], final)
    assert not np.delete(added, horizon - 1, 0).any()
    np.testing.assert_array_equal(np.argwhere(found.ended)[:, 0], horizon - 1)
    assert found.ended.sum() == COUNT
    np.testing.assert_array_equal(found.weight[:, 0], np.arange(STEPS) < horizon)


def test_a_simulation_that_breaks_down_has_failed_and_teaches_no_nonsense():
    task = toy_task("G_[0:9](A | !A)", robot=Bursting())
    _, _, episodes = explored("tau-mdp", task)
    sound = np.asarray(episodes.sound)
    assert 0 < sound.sum() < COUNT
    verdict = verdicts(task, episodes.margins, episodes.sound)
    np.testing.assert_array_equal(verdict == -np.inf, ~sound)
    assert np.isfinite(reward_of(task, verdict)).all() and np.isfinite(episodes.seen).all()


def test_a_recurrent_policy_learns_from_what_it_acted_by():
    """Read in one go, the episodes give the mean actions that were taken step by step."""
    task = toy_task(FORMULA)
    policy, state, episodes = explored("rnn", task)
    assert isinstance(policy, RecurrentPolicy)
    read = policy._encoded(state.weights.memory, episodes.seen)
    memory = policy.start(task.problem, state.weights, jnp.zeros(2))
    for step in range(STEPS):
        position = 5 * episodes.seen[step, 2, :2]
        acted = policy.act(task.problem, state.weights, memory, position)
        memory = acted.memory
        np.testing.assert_allclose(acted.seen, episodes.seen[step, 2], atol=1e-6)
        np.testing.assert_allclose(memory.hidden, read[step, 2, : policy.units], atol=1e-5)
    assert float(jnp.abs(memory.hidden).max()) > 0.01
