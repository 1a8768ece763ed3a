"""The critic of outcomes: what it sees, what it fits, and who uses it."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.methods import METHODS
from core.methods.tgpo.controller import TgpoController
from core.methods.tgpo.outcome import (
    SATISFIED,
    _logit,
    fit_outcome,
    outcome_features,
    outcome_targets,
)
from core.methods.training import TrainingConfig, fresh_state, state_from_weights
from core.rollout import start_states
from core.task.schedules import uniform_schedules


def test_targets_grow_with_robustness_where_the_formula_holds():
    robustness = np.array([-np.inf, -0.1, 0.0, 0.15, 0.3, 5.0])
    targets = outcome_targets(robustness, length=1.0)
    assert targets.tolist() == pytest.approx([0, 0, SATISFIED, 0.9, 1, 1])
    assert outcome_targets(np.array([0.15]), length=0.5).tolist() == pytest.approx([1.0])


def test_it_ranks_rollouts_of_missions_that_it_never_saw():
    """What decides differs from mission to mission by an offset that says nothing of the order."""
    random = np.random.default_rng(0)
    features = random.normal(size=(80, 64, 5)).astype(np.float32)
    features[..., 4] = random.normal(size=(80, 1))
    good = features[..., 0] - features[..., 1] + features[..., 4] > 0
    critic = fit_outcome(features[:60], np.where(good[:60], 0.9, 0.0), seed=1)
    logits = np.asarray(_logit(critic, jnp.asarray(features[60:])))
    for logit, label in zip(logits, good[60:], strict=True):
        if label.all() or not label.any():
            continue
        auc = (logit[label][:, None] > logit[~label]).mean()
        assert auc > 0.95


@pytest.fixture
def with_outcome(linear_task, small_algorithm):
    """Untrained weights with a critic of outcomes fitted to chance, and their controller."""
    algorithm = replace(small_algorithm, outcome=True)
    config = TrainingConfig(small_algorithm, "tgpo-star")
    weights = fresh_state(linear_task, config).learner.parameters
    shapes = METHODS["tgpo-star"].learner(linear_task, algorithm).weight_shapes()
    size = shapes.outcome.shift.shape[0]
    random = np.random.default_rng(2)
    critic = fit_outcome(random.normal(size=(16, 8, size)), random.random((16, 8)), seed=3)
    assert jax.tree.map(lambda leaf: leaf.shape, critic) == jax.tree.map(
        lambda leaf: leaf.shape, shapes.outcome
    )
    weights = weights._replace(outcome=critic)
    return weights, TgpoController(algorithm, weights)


def test_schedules_are_scored_by_it(linear_task, with_outcome):
    _, controller = with_outcome
    problem = linear_task.problem
    state = start_states(problem, jax.random.key(0), count=1)[0]
    schedules = uniform_schedules(problem.formula, jax.random.key(1), 64)
    scores = np.asarray(jax.vmap(partial(controller.score, problem, state))(schedules))
    assert ((scores > 0) & (scores < 1)).all() and len(np.unique(scores)) > 32


def test_a_training_that_begins_with_the_weights_leaves_it_behind(
    linear_task, small_algorithm, with_outcome
):
    weights, _ = with_outcome
    config = TrainingConfig(small_algorithm, "tgpo-star", warm=True)
    state = state_from_weights(linear_task, config, weights)
    assert state.learner.parameters.outcome is None and state.best.outcome is None
    np.testing.assert_array_equal(
        jax.tree.leaves(state.best.actor)[0], jax.tree.leaves(weights.actor)[0]
    )


def test_its_features_know_nothing_of_how_variables_are_numbered(linear_task, small_algorithm):
    """Padding with further variables changes nothing."""
    problem = linear_task.problem
    state = start_states(problem, jax.random.key(0), count=1)[0]
    schedule = uniform_schedules(problem.formula, jax.random.key(1), 1)[0]
    seen = outcome_features(small_algorithm, problem, state, schedule)
    unused = int(problem.formula.variables)
    assert unused < schedule.shape[0]
    other = outcome_features(small_algorithm, problem, state, schedule.at[unused:].set(7))
    np.testing.assert_array_equal(seen, other)
