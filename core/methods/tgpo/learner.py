"""What TGPO carries from epoch to epoch, and its update: PPO on a batch, and the elite.

Dimensions: C chains, V variables.
"""

from typing import Any, NamedTuple

import jax

from core.methods.networks import Parameters, make_networks
from core.methods.ppo import Transitions, improve
from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.collection import Batch
from core.methods.tgpo.sampler import Elite, update_elite
from core.task.protocols import Array


class LearnerState(NamedTuple):
    """Everything carried from one epoch to the next."""

    parameters: Parameters
    optimizer: Any
    key: Array
    chains: Array  # [C, V]
    elite: Elite


class EpochKeys(NamedTuple):
    """Random keys of an epoch by their purpose; each is used once."""

    collection: Array
    shuffling: Array
    following: Array
    """The learner's key in the next epoch."""


def epoch_keys(key: Array) -> EpochKeys:
    """The keys of the epoch that begins with the learner's key."""
    return EpochKeys(*jax.random.split(key, 3))


def update(state: LearnerState, batch: Batch, *, algorithm: Algorithm) -> LearnerState:
    """One epoch of PPO on a batch, and the elite's update."""
    networks = make_networks(algorithm.hidden, batch.noise.shape[-1])
    keys = epoch_keys(state.key)
    transitions = Transitions(
        batch.policy, batch.critic, batch.noise, batch.reward, batch.ended, batch.weight
    )
    learnt = state.parameters, state.optimizer
    parameters, optimizer = improve(algorithm, networks, learnt, transitions, keys.shuffling)
    elite = update_elite(state.elite, batch.schedule, batch.robustness, algorithm.elite_decay)
    return LearnerState(parameters, optimizer, keys.following, batch.chains, elite)
