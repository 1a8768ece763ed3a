"""Pushes taken as planned and planned anew."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.disturbances import Pushes, withstand
from core.errors import UserError
from core.rollout import start_states
from scenes import load_task
from studio.runs.tasks import build_task
from tests.core.test_answer import Seeker

ARENA = ((-5.0, 5.0), (-5.0, 5.0))
SEEKER = Seeker(jnp.ones(()))


@pytest.fixture(scope="module")
def task(disk_cache):
    return build_task(load_task("linear-demo"), "F_[0:60](A1) & F_[0:60](A2)")


@pytest.fixture(scope="module")
def states(task):
    return start_states(task.problem, jax.random.key(1), count=8)


def test_planning_anew_succeeds_where_the_plan_fails(task, states):
    found = withstand(task, SEEKER, states, Pushes(5.0, ARENA, 2, seed=3))
    assert (found.undisturbed >= 0).all()
    assert (found.anew >= 0).sum() > (found.as_planned >= 0).sum()
    assert not found.hopeless.any()  # nothing is forbidden
    assert found.seconds.shape == (16,)


def test_a_push_of_no_size_changes_nothing(task, states):
    found = withstand(task, SEEKER, states[:2], Pushes(0.0, ARENA))
    np.testing.assert_allclose(found.as_planned, found.undisturbed, atol=1e-4)


def test_the_seed_decides_the_pushes(task, states):
    one, same, other = (
        withstand(task, SEEKER, states[:4], Pushes(3.0, ARENA, seed=seed)) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one.as_planned, same.as_planned)
    np.testing.assert_array_equal(one.anew, same.anew)
    assert (one.as_planned != other.as_planned).any()


@pytest.mark.parametrize(("size", "count"), [(-1.0, 1), (np.inf, 1), (1.0, 0)])
def test_senseless_pushes_are_refused(task, states, size, count):
    with pytest.raises(UserError, match="must be finite and not negative, the number at least 1"):
        withstand(task, SEEKER, states[:1], Pushes(size, ARENA, count))
