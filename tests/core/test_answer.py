"""Answers before training: what is simulated, what is kept, and what is told of it."""

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.answer import DRAWS, ROUNDS, Effort, answer
from core.attempts import TRIED, Attempt, Attempts, Kind, of_every_kind, with_nudged
from core.candidates import Ranking
from core.deciding import Deciding
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
class Squinting(Seeker):
    """Ends 1 m beside the middle of every goal, whatever the schedule."""

    def step(self, problem, memory, state):
        return super().step(problem, memory, state - jnp.array([1.0, 0.0]))


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
    one, more = (
        answer(task, stuck, initial_state(task), effort=Effort(rounds, nudging=False))
        for rounds in (1, 3)
    )
    assert not one.plan.satisfied and not more.plan.satisfied
    assert more.tried > one.tried
    assert (one.rounds, more.rounds) == (1, 3)
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
    chosen = of_every_kind(Ranking(schedules, orders), np.zeros((5, 16, 2)))
    assert chosen.kinds.count(Kind((1, 0))) == 2
    assert chosen.schedules[:8, 0].tolist() == list(range(8))
    assert len(np.unique(chosen.schedules)) == 16


def test_few_candidates_are_repeated():
    drawn = Ranking(np.array([[5], [5], [6]]), np.zeros((3, 1), int))
    chosen = of_every_kind(drawn, np.zeros((5, 8, 2)))
    assert set(chosen.schedules[:, 0]) == {5, 6}
    assert len(chosen.schedules) == len(chosen.kinds) == 8
    assert chosen.distinct == 2


@pytest.fixture(scope="module")
def nudged(task):
    return answer(task, Squinting(jnp.ones(())), initial_state(task))


def test_nudged_actions_satisfy_what_the_controller_alone_does_not(task, nudged):
    alone = answer(task, Squinting(jnp.ones(())), initial_state(task), effort=Effort(nudging=False))
    assert not alone.plan.satisfied and not alone.plan.nudged
    assert alone.rounds == DRAWS
    assert nudged.plan.satisfied and nudged.plan.nudged
    assert 1 < nudged.rounds <= ROUNDS


def test_a_nudged_plan_is_a_trace_of_the_robot(task, nudged):
    plan = nudged.plan
    for step, action in enumerate(plan.actions):
        after = task.robot.step(jnp.asarray(plan.states[step]), jnp.asarray(action))
        np.testing.assert_allclose(after, plan.states[step + 1], atol=1e-5)
    assert plan.robustness == trace_robustness(task, plan.margins[:, None])[0]


def test_the_nudges_are_the_part_of_the_actions_that_is_not_the_controllers(task, nudged):
    plan, controller = nudged.plan, Squinting(jnp.ones(()))
    memory = controller.start(task.problem, jnp.asarray(plan.states[0]), jnp.asarray(plan.schedule))
    for step, state in enumerate(plan.states[:-1]):
        memory, own = controller.step(task.problem, memory, jnp.asarray(state))
        np.testing.assert_allclose(plan.actions[step] - own, plan.nudges[step], atol=1e-4)


def test_a_search_ends_with_what_it_has_when_it_is_interrupted(task):
    stuck = Seeker(jnp.zeros(()))
    found = answer(task, stuck, initial_state(task), effort=Effort(interrupted=lambda: True))
    assert found.rounds == 1 and not found.plan.satisfied


def test_parents_are_varied_in_turn_and_new_schedules_kept():
    drawn = Attempts(np.arange(8)[:, None], [Kind((0,))] * 8, np.zeros((5, 8, 2)))
    parents: list[Any] = [
        SimpleNamespace(
            schedule=np.array([100 + number]),
            kind=Kind((1,)),
            nudges=np.ones((5, 2)),
            deciding=Deciding(2, 0, 1),
        )
        for number in range(2)
    ]
    climbed = [Attempt(np.array([200]), Kind((2,)), np.full((5, 2), 7.0))]
    random = np.random.default_rng(0)
    made = with_nudged(random, drawn, parents, climbed, share=0.75)
    assert made.schedules[:, 0].tolist() == [0, 1, 200, 100, 101, 100, 101, 100]
    assert made.kinds == [Kind((0,))] * 2 + [Kind((2,))] + [Kind((1,))] * 5
    assert not made.nudges[:, :2].any()
    assert (made.nudges[:, 2] == 7.0).all()
    assert 0.5 < made.nudges[:, 3:].mean() < 1.5
    assert made.distinct == 8
    assert with_nudged(random, drawn, parents, [], share=1).schedules.min() == 100
