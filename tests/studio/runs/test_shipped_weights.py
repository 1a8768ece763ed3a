"""The weights that come with the program, on tasks that they were never trained on."""

import jax
import numpy as np
import pytest

from core.answer import answer
from core.evaluation import evaluate
from core.rollout import start_states
from core.task.physics import physics_of
from envs import ENVS
from scenes import load_task
from scenes.missions import HELD_OUT, TRAINED
from studio.runs.pretrained import has_weights, shipped_weights
from studio.runs.tasks import build_task

pytestmark = pytest.mark.optimised

LARGEST = 150_000
"""Size of a file of weights [bytes]."""


@pytest.mark.parametrize("robot", ENVS)
def test_the_demo_is_planned_in_either_order_and_from_other_starts(robot, disk_cache):
    """Demos are held out: neither formula nor layout was trained on."""
    task = build_task(load_task(f"{robot}-demo"))
    weights = shipped_weights(task)
    assert weights is not None
    simple = physics_of(task.robot) is None
    starts = start_states(task.problem, jax.random.key(5), count=8)[: 8 if simple else 2]
    found = [answer(task, weights.controller, state) for state in starts]
    assert all(one.plan.satisfied for one in found)
    orders = {plan.kind for one in found for plan in (one.plan, *one.alternatives)}
    assert len(orders) == 2
    chosen = evaluate(task, weights.controller, jax.random.key(6), count=64 if simple else 16)
    assert chosen.success_rate >= 0.8


@pytest.mark.parametrize("robot", ENVS)
def test_the_card_tells_what_was_never_trained_on(robot):
    weights = shipped_weights(build_task(load_task(f"{robot}-demo")))
    assert weights is not None
    card = weights.card
    assert "shipped" in card.families and set(card.families) <= {*TRAINED, "shipped"}
    assert not set(card.families) & set(HELD_OUT)
    assert [row.name for row in card.held_out] == ["formulas", *HELD_OUT]
    assert all(row.simulated <= row.tasks for row in card.held_out)
    assert weights.algorithm.share_elite == weights.algorithm.share_mcmc == 0


@pytest.mark.parametrize("robot", ENVS)
def test_the_files_are_small_and_sound(robot):
    assert has_weights(robot)
    weights = shipped_weights(build_task(load_task(f"{robot}-08")))
    assert weights is not None
    leaves = jax.tree.leaves(weights.weights)
    assert 4 * sum(leaf.size for leaf in leaves) < LARGEST
    assert all(np.isfinite(np.asarray(leaf)).all() for leaf in leaves)
