"""Answers before training: what is simulated, what is kept, and what is told of it."""

from dataclasses import dataclass
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.answer import TRIED, Kind, _of_every_kind, answer
from core.evaluation import trace_robustness
from core.task.schedules import Search
from core.task.windows import windows_of
from scenes import load_task
from studio.runs.tasks import build_task, initial_state


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Seeker:
    """Goes straight to the middle of the subgoal that opens next; likes every schedule."""

    speed: jax.Array

    search = Search()

    @property
    def attempts(self):
        return (self,)

    def score(self, problem, state, schedule):
        return jnp.zeros(())

    def start(self, problem, state, schedule):
        windows = windows_of(problem, schedule)
        return windows.order, windows.end, jnp.zeros(())

    def step(self, problem, memory, state):
        order, end, tau = memory
        target = problem.center[order[(end > tau).argmax()]]
        away = target - problem.robot.position(state)
        return (order, end, tau + 1), self.speed * jnp.clip(5 * away, -1.0, 1.0)


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Reactive(Seeker):
    """The same, but it knows no schedules."""

    search: Any = None


@pytest.fixture(scope="module")
def task(disk_cache):
    return build_task(load_task("linear-demo"), "F_[0:60](A1) & F_[0:60](A2)")


@pytest.fixture(scope="module")
def found(task):
    return answer(task, Seeker(jnp.ones(())), initial_state(task))


def test_a_plan_is_found_with_its_exact_robustness(task, found):
    plan = found.plan
    assert plan.satisfied
    assert plan.robustness == trace_robustness(task, plan.margins[:, None])[0]
    np.testing.assert_array_equal(plan.states[0], initial_state(task))
    assert 1 <= found.tried <= TRIED


def test_the_other_order_is_an_alternative(found):
    (other,) = found.alternatives
    assert {found.plan.kind, other.kind} == {Kind((0, 1)), Kind((1, 0))}
    assert other.satisfied and other.robustness <= found.plan.robustness


def test_the_same_seed_gives_the_same_plan(task, found):
    again = answer(task, Seeker(jnp.ones(())), initial_state(task))
    np.testing.assert_array_equal(again.plan.schedule, found.plan.schedule)
    assert again.plan.robustness == found.plan.robustness


def test_without_a_plan_more_is_drawn_and_the_nearest_miss_is_told(task):
    stuck = Seeker(jnp.zeros(()))
    one, more = (answer(task, stuck, initial_state(task), rounds=rounds) for rounds in (1, 3))
    assert not one.plan.satisfied and not more.plan.satisfied
    assert more.tried > one.tried
    assert -10 < more.plan.robustness < 0 and more.alternatives == ()


def test_a_controller_without_schedules_is_tried_once(task):
    found = answer(task, Reactive(jnp.zeros(())), initial_state(task))
    assert not found.plan.satisfied
    assert found.tried == 1


def test_every_kind_is_tried_and_the_best_most():
    """One candidate in a hundred is of the second kind and liked least."""
    schedules = np.arange(200)[:, None]
    orders = np.tile([[0, 1, -1]], (200, 1))
    orders[-2:] = [1, 0, -1]
    chosen = _of_every_kind(orders, schedules, 16)
    assert chosen.kinds.count(Kind((1, 0))) == 2
    assert chosen.schedules[:8, 0].tolist() == list(range(8))
    assert len(np.unique(chosen.schedules)) == 16


def test_few_candidates_are_repeated():
    chosen = _of_every_kind(np.zeros((3, 1), int), np.array([[5], [5], [6]]), 8)
    assert set(chosen.schedules[:, 0]) == {5, 6}
    assert len(chosen.schedules) == len(chosen.kinds) == 8
