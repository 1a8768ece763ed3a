"""Pieces of the modes that can be switched off: each does that and nothing else."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.mdp.grounded import ground_schedule
from core.mdp.mode import advance, begin
from core.mdp.paper_mode import PaperMode
from core.mdp.studio_mode import StudioMode
from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.collection import collect
from core.methods.tgpo.method import Tgpo, _sources
from tests.core.toy import CENTERS, disc_margins, toy_task

FORMULA = "F_[0:9](A) & G_[0:14](!C)"
SCHEDULE = jnp.array([9] + [0] * 7, jnp.int32)


@partial(jax.jit, static_argnums=0)
def walked(mode, problem, actions):
    """Views and rewards of a walk from the origin, as `jax.lax.scan` stacks them."""
    state = jnp.zeros(2)
    mdp = ground_schedule(problem, state, SCHEDULE, reserve=1.2)

    def step(view, action):
        moved = problem.robot.step(view.episode.state, action)
        after, reward, ends = advance(mode, mdp, view, moved)
        return after, (after, reward, ends)

    return jax.lax.scan(step, begin(mode, mdp, state, jnp.float32(0)), actions)[1]


def towards(name, steps=14):
    """Actions that lead from the origin to a disc in four steps, and stay."""
    actions = np.zeros((steps, 2), np.float32)
    actions[:4] = np.asarray(CENTERS[name]) / 0.5 / 4
    return jnp.asarray(actions)


def test_without_fields_the_way_is_straight_and_the_world_is_not_asked():
    task = toy_task(FORMULA)
    told = replace(task.problem, world=Detour())
    mode = StudioMode(ahead=(0.5,))
    with_field = walked(mode, told, towards("A"))[0].sense
    np.testing.assert_allclose(with_field.distance[0], 7.0)
    straight = walked(replace(mode, fields=False), told, towards("A"))[0]
    outside = -np.asarray(disc_margins(np.asarray(straight.episode.state)))[:, 0]
    before = np.asarray(straight.episode.tau) < 9  # A is the subgoal until then
    np.testing.assert_allclose(
        np.asarray(straight.sense.distance)[before], np.maximum(outside, 0)[before], atol=1e-5
    )
    unit = np.asarray(CENTERS["A"]) / np.linalg.norm(CENTERS["A"])
    np.testing.assert_allclose(straight.sense.direction[0], unit, atol=1e-4)
    np.testing.assert_allclose(straight.sense.ahead[0, 0], unit, atol=1e-4)


def test_without_early_end_a_failed_episode_lasts_and_is_paid_for():
    task, mode = toy_task(FORMULA), StudioMode(scale=1.0, shape=0.0)
    actions = towards("C")
    views, rewards, ends = walked(mode, task.problem, actions)
    first = int(np.argmax(np.asarray(views.episode.alive) == 0))
    assert ends[first] and rewards[first] == mode.violation
    lasting = replace(mode, early_end=False)
    views, rewards, ends = walked(lasting, task.problem, actions)
    assert not ends[:-1].any() and ends[-1] == (views.episode.tau[-1] >= task.horizon)
    np.testing.assert_allclose(rewards[first:], mode.violation)
    assert (views.episode.alive[first:] == 0).all() and (views.episode.progress == 0).all()


def test_without_early_end_every_transition_is_learnt_from():
    task = toy_task(FORMULA)

    def batch(mode):
        algorithm = Algorithm(mode=mode, environments=32, hidden=(8,), elite_capacity=32)
        learner = Tgpo("tgpo-star", "").learner(task, algorithm)
        sources = _sources(learner.fresh(1))
        run = jax.jit(partial(collect, algorithm=algorithm, steps=task.padded_horizon))
        return run(task.problem, sources, jax.random.key(0))

    assert batch(StudioMode(exploring=1.0)).weight.min() == 0
    lasting = batch(StudioMode(exploring=1.0, early_end=False))
    assert lasting.weight.min() == 1
    ends = np.argmax(np.asarray(lasting.ended), axis=0) + 1  # of the first episodes
    assert (ends == task.horizon).all()


def test_without_features_the_networks_see_the_papers_state():
    task, actions = toy_task(FORMULA), towards("A")
    plain, _, _ = walked(StudioMode(features=False), task.problem, actions)
    paper, _, _ = walked(PaperMode(), task.problem, actions)
    assert plain.policy.shape == paper.policy.shape
    np.testing.assert_array_equal(plain.policy, plain.critic)
    np.testing.assert_array_equal(plain.policy[:, :4], paper.policy[:, :4])  # position, time


@pytest.mark.parametrize(("time", "flags"), [(True, False), (False, False), (False, True)])
def test_parts_of_the_papers_state_can_be_left_out(time, flags):
    task = toy_task(FORMULA)
    state, mode = jnp.zeros(2), PaperMode(time=time, flags=flags)
    mdp = ground_schedule(task.problem, state, SCHEDULE, reserve=1.2)
    view = begin(mode, mdp, state, jnp.float32(0))

    def seen(**changes):
        return mode.policy_features(mdp, view.episode._replace(**changes), view.sense)

    assert (seen(tau=jnp.float32(5)) != view.policy).any() == time
    for change in (
        {"previous_progress": jnp.int32(1)},
        {"progress": jnp.int32(1)},
        {"certificate": jnp.int32(2)},
        {"satisfied": jnp.zeros_like(view.episode.satisfied)},
    ):
        assert (seen(**change) != view.policy).any() == flags
    whole = begin(PaperMode(), mdp, state, jnp.float32(0)).policy
    assert view.policy.size < whole.size


class Detour:
    """The toy's world, in which every way is 7 m long and leads down."""

    def __init__(self):
        self._world = toy_task(FORMULA).problem.world

    def __getattr__(self, name):
        return getattr(self._world, name)

    def __hash__(self):
        return hash(self._world)

    def __eq__(self, other):
        return isinstance(other, Detour)

    def field(self, data, index, position):
        del data, index, position
        return jnp.float32(7.0), jnp.array([0.0, -1.0])
