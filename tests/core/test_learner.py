"""PPO on probe environments whose values and best actions are known."""

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.algorithm import Algorithm
from core.collection import collect
from core.learner import advantages, update
from core.programs import fresh_learner, setting_of
from tests.core.toy import toy_task


class ProbeEpisode(NamedTuple):
    state: Any
    tau: Any
    alive: Any
    robustness: Any


@dataclass(frozen=True)
class Probe:
    """A mode whose reward and end are given; what is observed is a random bit and the time."""

    kind: str
    scale: float = 1.0
    exploring: float = 0.0
    gradual_stays: bool = False

    def begin(self, robot, world, problem, windows, state, tau):
        del robot, world, problem, windows
        bit = jnp.sign(state[0])
        return ProbeEpisode(state, tau, jnp.ones(()), jnp.zeros(())), bit

    def advance(self, robot, world, problem, windows, episode, sense, action):
        del world, problem, windows
        tau = episode.tau + 1
        reward, ends = {
            "constant": (1.0, True),
            "action": (-((action[0] - 0.5) ** 2), True),
            "delayed": (jnp.where(tau == 2, 1.0, 0.0), tau >= 2),
            "endless": (1.0, False),
            "observed": (sense, True),
        }[self.kind]
        state = robot.step(episode.state, 0 * action)
        following = ProbeEpisode(state, tau, episode.alive, episode.robustness)
        return following, sense, jnp.float32(reward), jnp.asarray(ends)

    def succeeded(self, windows, episode):
        del windows
        return episode.alive > 0

    def policy_features(self, robot, problem, windows, episode, sense):
        del robot, problem, windows
        return jnp.stack([sense, jnp.where(self.kind == "delayed", episode.tau, 0.0)])

    def critic_features(self, problem, windows, slack, shortfall, episode, sense, features):
        del problem, windows, slack, shortfall, episode, sense
        return features


def _train(kind, epochs, **changes):
    task = toy_task("F_[0:9](A)")
    probe: Any = Probe(kind)
    algorithm = replace(
        Algorithm(),
        mode=probe,
        environments=64,
        minibatches=4,
        prune=False,
        share_mcmc=0.0,
        learning_rate=5e-3,
        hidden=(32, 32),
        **changes,
    )
    setting = setting_of(task, algorithm)
    learner = fresh_learner(task, algorithm, 0)

    @jax.jit
    def epoch(state, key):
        batch = collect(setting, task.problem, state.parameters, state.chains, state.elite, key)
        return update(setting, state, batch)

    for i in range(epochs):
        learner = epoch(learner, jax.random.key(i))
    return setting.networks, learner.parameters


BITS = jnp.array([[-1.0, 0.0], [1.0, 0.0]])


def test_constant_reward_is_the_value():
    networks, parameters = _train("constant", 20)
    np.testing.assert_allclose(networks.value(parameters, BITS), 1.0, atol=0.05)


def test_value_of_an_observation():
    networks, parameters = _train("observed", 30)
    np.testing.assert_allclose(networks.value(parameters, BITS), [-1.0, 1.0], atol=0.1)


def test_delayed_reward_is_discounted_once():
    networks, parameters = _train("delayed", 40, discount=0.5)
    features = jnp.array([[1.0, 0.0], [1.0, 1.0]])
    np.testing.assert_allclose(networks.value(parameters, features), [0.5, 1.0], atol=0.07)


def test_truncation_is_no_end():
    """An endless reward of 1 is worth 1 / (1 - gamma) = 5, though every batch breaks it off."""
    networks, parameters = _train("endless", 60, discount=0.8)
    np.testing.assert_allclose(networks.value(parameters, BITS), 5.0, atol=0.25)


def test_policy_finds_the_best_action():
    networks, parameters = _train("action", 40)
    np.testing.assert_allclose(networks.action(parameters, BITS)[:, 0], 0.5, atol=0.1)


@pytest.mark.parametrize("trace", [0.0, 0.7, 1.0])
def test_advantages_by_their_definition(trace):
    """Sum over l of (gamma lambda)^l delta_{t+l}, cut at the end of the episode."""
    random = np.random.default_rng(1)
    steps, gamma = 12, 0.9
    reward = random.normal(size=(steps, 3)).astype(np.float32)
    value = random.normal(size=(steps + 1, 3)).astype(np.float32)
    ended = (random.random((steps, 3)) < 0.2).astype(np.float32)
    delta = reward + gamma * value[1:] * (1 - ended) - value[:-1]
    expected = np.zeros_like(reward)
    for t in range(steps):
        for n in range(3):
            factor = 1.0
            for k in range(t, steps):
                expected[t, n] += factor * delta[k, n]
                factor *= gamma * trace * (1 - ended[k, n])
    found = advantages(jnp.asarray(reward), jnp.asarray(value), jnp.asarray(ended), gamma, trace)
    np.testing.assert_allclose(found, expected, atol=1e-4)
