"""PPO on probe environments whose values and best actions are known."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.methods.networks import networks_of
from core.methods.ppo import advantages
from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.collection import Sources, collect
from core.methods.tgpo.learner import update
from core.methods.tgpo.method import TgpoLearner
from tests.core.toy import toy_task


class ProbeEpisode(NamedTuple):
    state: Any
    tau: Any
    alive: Any
    robustness: Any
    action: Any


@dataclass(frozen=True)
class Probe:
    """A mode whose reward and end are given; what is observed is a random bit and the time."""

    kind: str
    name: ClassVar[str] = "probe"
    pays_robustness: ClassVar[bool] = False
    scale: float = 1.0
    exploring: float = 0.0
    gradual_stays: bool = False
    early_end: bool = True

    def begin(self, mdp, state, tau):
        del mdp
        return ProbeEpisode(state, tau, jnp.ones(()), jnp.zeros(()), state), jnp.sign(state[0])

    def observe(self, mdp, episode, state):
        del mdp
        after = episode._replace(state=state, tau=episode.tau + 1, action=state - episode.state)
        return after, jnp.sign(episode.state[0])

    def reward(self, mdp, before, after):
        del mdp
        (_, bit), (episode, _) = before, after
        action = episode.action[0] / toy_task("F_[0:9](A)").robot.speed
        reward, ends = {
            "constant": (1.0, True),
            "action": (-((action - 0.5) ** 2), True),
            "delayed": (jnp.where(episode.tau == 2, 1.0, 0.0), episode.tau >= 2),
            "endless": (1.0, False),
            "observed": (bit, True),
        }[self.kind]
        return jnp.float32(reward), jnp.asarray(ends)

    def succeeded(self, mdp, episode):
        del mdp
        return episode.alive > 0

    def policy_features(self, mdp, episode, sense):
        del mdp
        return jnp.stack([sense, jnp.where(self.kind == "delayed", episode.tau, 0.0)])

    def critic_features(self, mdp, episode, sense, features):
        del mdp, episode, sense
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
    learner, steps = TgpoLearner(task, algorithm), task.padded_horizon
    state = learner.fresh(0)

    @jax.jit
    def epoch(state, key):
        sources = Sources(state.parameters, state.chains, state.elite)
        batch = collect(task.problem, sources, key, algorithm=algorithm, steps=steps)
        return update(state, batch, algorithm=algorithm)

    for i in range(epochs):
        state = epoch(state, jax.random.key(i))
    return networks_of(algorithm, task.problem), state.parameters


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
