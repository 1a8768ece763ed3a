"""Episodes whose tasks must hold between the steps, against plain NumPy on random jumps."""

from dataclasses import replace
from functools import partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.between import SUBSTEPS
from core.mdp.grounded import AXES
from core.mdp.mode import advance, first_views
from core.mdp.paper_mode import PaperMode
from core.mdp.studio_mode import StudioMode
from core.stl import robustness_signal
from tests.core.toy import CENTERS, disc_margins, toy_task

FORMULA = "F_[0:6](G_[0:3](!A)) & G_[2:14](!B) & (!D) U_[0:9] !C"
JUMPS, STEPS = 300, 16


@partial(jax.jit, static_argnums=0)
def _episodes(mode, problem, schedules, states):
    mdps, view = first_views(mode, problem, states[0], schedules, 1.2)

    def step(view, state):
        after, reward, _ = jax.vmap(partial(advance, mode), (AXES, 0, 0))(mdps, view, state)
        return after, (after.episode, reward)

    return jax.lax.scan(step, view, states[1:])[1]


@pytest.mark.parametrize("mode", [StudioMode(scale=1.0), PaperMode()], ids=["studio", "paper"])
def test_the_least_margin_between_the_steps_counts(mode):
    task = toy_task(FORMULA)
    shares = jnp.arange(1, SUBSTEPS) / SUBSTEPS
    problem = replace(task.problem, between=shares)
    random = np.random.default_rng(2)
    low, high = np.asarray(problem.formula.low), np.asarray(problem.formula.high)
    schedules = random.integers(low, high + 1, (JUMPS, len(low)))
    states = np.cumsum(random.normal(0, 0.4, (STEPS + 1, JUMPS, 2)), 0).astype(np.float32)
    given = jnp.asarray(schedules, jnp.int32), jnp.asarray(states)
    episode, reward = jax.tree.map(np.asarray, _episodes(mode, problem, *given))
    plain, plain_reward = jax.tree.map(np.asarray, _episodes(mode, task.problem, *given))

    caught = 0
    for jump in range(JUMPS):
        worst = _least(task, schedules[jump].tolist(), states[:, jump])
        np.testing.assert_allclose(episode.robustness[-1, jump], worst, atol=1e-4)
        caught += plain.robustness[-1, jump] > worst + 1e-3
    assert caught > JUMPS / 20
    assert (episode.satisfied <= plain.satisfied).all() and (
        episode.satisfied < plain.satisfied
    ).any()
    assert (episode.alive <= plain.alive).all()
    assert (reward != plain_reward).any()


def _least(task, schedule, states):
    """Least margin of the tasks of a schedule at and between the steps of a trace [T + 1, 2]."""
    share = np.linspace(0, 1, SUBSTEPS + 1)[:, None]
    fine = states[:-1, None] + share * np.diff(states, axis=0)[:, None]
    margins = disc_margins(fine).reshape(-1, len(CENTERS))
    worst = np.inf
    for item, start, end in task.grounding.decomposition.active_tasks(schedule):
        signal = robustness_signal(item.predicate, margins, tuple(CENTERS))
        along = np.asarray(signal).reshape(STEPS, SUBSTEPS + 1)
        at = np.append(along[:, 0], along[-1, -1])
        worst = min(worst, at[start : end + 1].min(initial=np.inf))
        worst = min(worst, along[start:end].min(initial=np.inf))
    return worst
