"""Trainings that begin with weights learnt elsewhere."""

from dataclasses import replace

import jax
import numpy as np

from core.methods.training import PATIENCE, TrainingConfig, fresh_state, state_from_weights, train


def _same(one, other) -> bool:
    pairs = zip(jax.tree.leaves(one), jax.tree.leaves(other), strict=True)
    return all(np.array_equal(np.asarray(a), np.asarray(b)) for a, b in pairs)


def _networks(state):
    parameters = state.learner.parameters
    return parameters.actor, parameters.critic


def test_exploration_is_reset(linear_task, small_algorithm):
    config = TrainingConfig(small_algorithm)
    weights = fresh_state(linear_task, config).learner.parameters
    settled = weights._replace(log_std=weights.log_std - 3)
    begun = state_from_weights(linear_task, config, settled)
    assert _same(begun.learner.parameters, weights)
    assert _same(begun.best, weights)  # what the policy and the critic do is the same


def test_weights_that_lead_nowhere_are_given_up(linear_task, small_algorithm):
    """Untrained networks of 16 environments learn nothing in `PATIENCE` epochs."""
    cold = TrainingConfig(small_algorithm, seed=5, epochs=PATIENCE, evaluate_every=5)
    warm = replace(cold, warm=True)
    other = fresh_state(linear_task, replace(cold, seed=6))
    begun = state_from_weights(linear_task, warm, other.learner.parameters)
    *_, given_up = train(linear_task, warm, begun)
    assert _same(_networks(given_up.state), _networks(fresh_state(linear_task, warm)))
    *_, kept = train(linear_task, cold, begun)
    assert not _same(_networks(kept.state), _networks(fresh_state(linear_task, cold)))
