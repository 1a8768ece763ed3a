from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.methods.tgpo.sampler import Elite, metropolis_hastings, update_elite
from core.task.schedules import Search, feasible_schedules, shortfall, uniform_schedules
from tests.core.toy import toy_task

TWO = toy_task("F_[2:7](A) & F_[0:4](B)").problem.formula
NONE = toy_task("G_[0:9](!A)").problem.formula


def _density(schedule):
    """A log density with two hills over the 6 x 5 schedules of TWO."""
    t = schedule.astype(jnp.float32)
    return 1.5 * jnp.cos(1.3 * t[..., 0]) + jnp.sin(0.9 * t[..., 1] + t[..., 0] / 3)


@pytest.mark.parametrize("strides", [(1,), (1, 2, 4, 8)])
def test_chains_sample_the_exact_softmax(strides):
    """20,000 chains after 120 steps against the softmax; 30 cells, so noise is about 0.02."""
    key = jax.random.key(0)
    start = uniform_schedules(TWO, key, 20_000)
    chains = metropolis_hastings(
        _density, TWO, jax.random.key(1), start, steps=120, warmup=0, strides=strides
    )
    cells = np.asarray(chains.last[:, 0] - 2) * 5 + np.asarray(chains.last[:, 1])
    found = np.bincount(cells, minlength=30) / len(cells)
    grid = jnp.stack(jnp.meshgrid(jnp.arange(2, 8), jnp.arange(5), indexing="ij"), -1)
    exact = np.asarray(jax.nn.softmax(_density(grid).reshape(-1)))
    assert 0.5 * np.abs(found - exact).sum() < 0.03
    assert 0.5 * np.abs(exact - 1 / 30).sum() > 0.3  # the uniform start is far from it
    assert 0.1 < float(chains.accepted) < 0.95


def test_chains_stay_in_the_domain_and_leave_padding_alone():
    start = uniform_schedules(TWO, jax.random.key(0), 64)
    chains = metropolis_hastings(
        lambda s: 0.0 * s[:, 0], TWO, jax.random.key(1), start, steps=50, warmup=0
    )
    last = np.asarray(chains.last)
    assert (last >= np.asarray(TWO.low)).all() and (last <= np.asarray(TWO.high)).all()
    assert (last[:, 2:] == 0).all()
    assert not np.array_equal(last, np.asarray(start))


def test_best_of_a_chain_is_its_highest_density_after_the_warm_up():
    start = uniform_schedules(TWO, jax.random.key(2), 32)
    with_all = metropolis_hastings(_density, TWO, jax.random.key(3), start, steps=60, warmup=0)
    late = metropolis_hastings(_density, TWO, jax.random.key(3), start, steps=60, warmup=59)
    assert (_density(with_all.best) >= _density(with_all.last)).all()
    assert np.array_equal(late.best, late.last)


def test_no_variables_at_all():
    start = uniform_schedules(NONE, jax.random.key(0), 8)
    chains = metropolis_hastings(
        lambda s: 0.0 * s[:, 0], NONE, jax.random.key(1), start, steps=5, warmup=0
    )
    assert not np.asarray(chains.last).any() and float(chains.accepted) == 0


def test_uniform_schedules_fill_the_domain_evenly():
    drawn = np.asarray(uniform_schedules(TWO, jax.random.key(5), 30_000))
    counts = np.bincount((drawn[:, 0] - 2) * 5 + drawn[:, 1], minlength=30)
    assert counts.size == 30
    assert np.abs(counts / 1000 - 1).max() < 0.15


def test_feasible_schedules_are_uniform_over_those_that_leave_time():
    problem, count = toy_task("F_[0:15](A) & F_[0:9](B)").problem, 9_000
    size = problem.formula.low.shape[0]
    every = np.zeros((160, size), np.int32)
    every[:, :2] = np.indices((16, 10)).reshape(2, -1).T
    needed = jax.vmap(partial(shortfall, problem, jnp.zeros(2), reserve=Search().reserve))
    in_time = np.asarray(needed(jnp.asarray(every))) <= 0
    assert in_time.sum() == 45
    states = jnp.zeros((count, 2))
    drawn = np.asarray(feasible_schedules(problem, Search(), jax.random.key(1), states))
    counts = np.bincount(drawn[:, 0] * 10 + drawn[:, 1], minlength=160)
    assert counts[in_time].sum() > 0.999 * count
    assert np.abs(counts[in_time] / (count / 45) - 1).max() < 0.25


def test_elite_keeps_the_best():
    elite = Elite(jnp.zeros((3, 2), jnp.int32), jnp.array([1.0, 5.0, -1e6]))
    new = jnp.array([[1, 1], [2, 2]], jnp.int32)
    updated = update_elite(elite, new, jnp.array([3.0, 0.5]), decay=1.0)
    assert updated.scores.tolist() == [4.0, 3.0, 0.5]
    assert updated.schedules.tolist() == [[0, 0], [1, 1], [2, 2]]
