"""Every random key of an epoch has one purpose and is used once."""

from collections import Counter

import jax
import numpy as np
import pytest

from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.collection import Sources, collect
from core.methods.tgpo.learner import epoch_keys, update
from core.methods.tgpo.method import TgpoLearner
from tests.core.toy import toy_task

SMALL = Algorithm(
    environments=8, hidden=(8,), minibatches=2, passes=2, mcmc_steps=2, elite_capacity=8
)
CONSUMERS = ("split", "uniform", "normal", "randint", "permutation", "choice")


@pytest.fixture
def used(monkeypatch) -> Counter:
    """How often each key's value is handed to a function of jax.random; `fold_in` with its data."""
    counter: Counter = Counter()

    def note(*values: np.ndarray) -> None:
        counter[tuple(int(number) for value in values for number in np.ravel(value))] += 1

    def recorded(function):
        def called(key, *arguments, **options):
            jax.debug.callback(note, jax.random.key_data(key))
            return function(key, *arguments, **options)

        return called

    def folded(key, data, original=jax.random.fold_in):
        jax.debug.callback(note, jax.random.key_data(key), data)
        return original(key, data)

    for name in CONSUMERS:
        monkeypatch.setattr(jax.random, name, recorded(getattr(jax.random, name)))
    monkeypatch.setattr(jax.random, "fold_in", folded)
    return counter


def test_no_key_recurs_in_two_epochs(used):
    task = toy_task("F_[0:9](G_[0:2](A)) & F_[0:9](B)")
    state = TgpoLearner(task, SMALL).fresh(0)

    @jax.jit
    def epoch(state):
        sources = Sources(state.parameters, state.chains, state.elite)
        key = epoch_keys(state.key).collection
        batch = collect(task.problem, sources, key, algorithm=SMALL, steps=task.padded_horizon)
        return update(state, batch, algorithm=SMALL)

    state = epoch(state)
    first = Counter(used)
    assert len(first) > 50
    # The key of an epoch is split once for the batch and once for the update: the same children.
    assert [count for count in first.values() if count > 1] in ([], [2])
    epoch(state)
    jax.effects_barrier()
    assert sum(count > 1 for count in used.values()) <= 2


def test_a_key_that_is_used_twice_is_seen(used):
    key = jax.random.key(3)
    jax.jit(lambda key: jax.random.uniform(key) + jax.random.normal(key))(key)
    jax.effects_barrier()
    assert max(used.values()) == 2
