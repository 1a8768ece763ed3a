"""The augmented MDP against plain-Python readings of its definition, on random walks."""

from functools import cache, partial

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from core.decompose import Kind
from core.mdp.episode import before_start
from core.mdp.grounded import AXES, ground_schedule
from core.mdp.mode import advance, begin, first_views
from core.mdp.paper_mode import PaperMode
from core.mdp.studio_mode import StudioMode
from tests.core.toy import CENTERS, disc_margins, toy_task

FORMULAS = [
    "F_[0:6](A) & F_[2:9](B)",
    "F_[0:6](G_[0:3](A)) & G_[0:14](!B)",
    "(!A)U_[0:9](B) & F_[0:12](C)",
    "G_[0:5](!A) & F_[0:4](G_[0:8](!B | A)) & F_[1:8](B & !C)",
    "F_[0:5](A & F_[0:5](G_[0:2](A)) & F_[0:5](B))",
    "F_[0:8](A) | F_[0:8](B & F_[0:4](C))",
    "G_[0:6](F_[0:4](A))",
    "G_[0:9](A | B | C | D)",
]
WALKS = 200


@partial(jax.jit, static_argnums=0)
def _walk(mode, problem, schedules, states, goals):
    """Head for each goal in turn; one program for all formulas."""
    mdps, start = first_views(mode, problem, states, schedules, 1.2)

    def step(view, goal):
        action = 2 * (goal - view.episode.state)
        states = jax.vmap(problem.robot.step)(view.episode.state, action)
        after, reward, ends = jax.vmap(partial(advance, mode), (AXES, 0, 0))(mdps, view, states)
        return after, (after, reward, ends)

    _, (views, rewards, ends) = jax.lax.scan(step, start, goals)
    return mdps, start, views, rewards, ends


@cache
def _walks(formula, mode, seed):
    """Random walks between the discs with random schedules, as arrays over [steps + 1, walks]."""
    task = toy_task(formula)
    random = np.random.default_rng(seed)
    domains = task.problem.formula
    low, high = np.asarray(domains.low), np.asarray(domains.high)
    schedules = jnp.asarray(random.integers(low, high + 1, (WALKS, 8)), jnp.int32)
    places = np.array([*CENTERS.values(), (0.0, 0.0)])
    states = jnp.asarray(places[random.integers(0, 5, WALKS)], jnp.float32)
    targets = np.repeat(random.integers(0, 5, (task.horizon // 4 + 1, WALKS)), 4, axis=0)
    goals = jnp.asarray(places[targets[: task.horizon]], jnp.float32)

    mdps, start, views, rewards, ends = _walk(mode, task.problem, schedules, states, goals)
    episodes = jax.tree.map(
        lambda first, rest: np.concatenate([np.asarray(first)[None], np.asarray(rest)]),
        start.episode,
        views.episode,
    )
    return mdps, np.asarray(schedules), episodes, np.asarray(rewards), np.asarray(ends)


def _task_margin(task, item, margins):
    """Margin over time of a task's predicate on a trace of margins [T, 4]."""
    from core.stl import robustness_signal

    return np.asarray(robustness_signal(item.predicate, margins, tuple(CENTERS)))


@pytest.mark.parametrize("formula", FORMULAS)
def test_studio_episode_succeeds_iff_every_task_holds(formula):
    task = toy_task(formula)
    mdps, schedules, episodes, _, ends = _walks(formula, StudioMode(), 7)
    succeeded = jax.vmap(jax.vmap(StudioMode().succeeded, (None, 0)), (AXES, 1))(
        mdps, jax.tree.map(jnp.asarray, episodes)
    ).T
    outcomes = set()
    for walk in range(WALKS):
        margins = disc_margins(episodes.state[:, walk])
        active = task.grounding.decomposition.active_tasks(schedules[walk].tolist())
        worst = np.inf
        violated = []
        for item, start, end in active:
            window = _task_margin(task, item, margins)[start : end + 1]
            if start <= end:
                worst = min(worst, window.min())
                violated += [start + int(np.argmax(window < 0))] if window.min() < 0 else []
        if abs(worst) < 1e-4:
            continue
        outcomes.add(worst >= 0)
        assert bool(succeeded[-1, walk]) == (worst >= 0)
        np.testing.assert_allclose(episodes.robustness[-1, walk], worst, atol=1e-4)
        if violated:
            assert not episodes.alive[min(violated) :, walk].any()
            assert episodes.alive[: min(violated), walk].all()
            assert min(violated) == 0 or ends[min(violated) - 1, walk]
    assert False in outcomes  # random walks fail often; most formulas also see a success


def test_random_walks_see_successes():
    """The positive control of the test above."""
    robustness = [_walks(f, StudioMode(), 7)[2].robustness[-1] for f in FORMULAS]
    assert sum((r >= 0).any() for r in robustness) >= 4


def _paper_reference(task, schedule, margins, mode):
    """Sec. 4.2 in plain Python: (p_prev, p, r, chi) and the reward at every step."""
    active = task.grounding.decomposition.active_tasks(schedule)
    active = [(i, s, e) for i, s, e in active if s <= e]
    goals = sorted((w for w in active if w[0].kind is not Kind.INVARIANT), key=lambda w: w[1])
    constraints = [w for w in active if w[0].kind is Kind.INVARIANT]
    signals = {id(item): _task_margin(task, item, margins) for item, _, _ in active}

    def flag(r, p, tau):
        if r == 2 or p >= len(goals):
            return 0
        item, start, end = goals[p]
        inside = signals[id(item)][tau] >= 0
        if start != end and tau == start and inside:
            return 1
        if (r == 1 or start == end) and tau == end and inside:
            return 2
        return r

    def kept(tau):
        return [not (s <= tau <= e and signals[id(i)][tau] < 0) for i, s, e in constraints]

    r = flag(0, 0, 0)
    p, chi, rows = int(r == 2), kept(0), []
    for tau in range(1, len(margins)):
        previous, r = p, flag(r, p, tau)
        p += r == 2
        chi = [a and b for a, b in zip(chi, kept(tau), strict=True)]
        present = signals[id(goals[p][0])][tau] if p < len(goals) else 0.0
        reward = mode.distance * present + mode.progress * (p != previous)
        reward += mode.success * (p == len(goals) and all(chi))
        reward += mode.violation * (not all(chi))
        rows.append((previous, p, r, all(chi), reward))
    return rows


@pytest.mark.parametrize("formula", FORMULAS)
def test_paper_transition_and_reward_to_the_letter(formula):
    task = toy_task(formula)
    mode = PaperMode(scale=1.0)
    _, schedules, episodes, rewards, ends = _walks(formula, mode, 11)
    assert not ends[:-1].any() and ends[-1].all()
    for walk in range(WALKS):
        margins = disc_margins(episodes.state[:, walk])
        rows = _paper_reference(task, schedules[walk].tolist(), margins, mode)
        for step, (previous, p, r, kept, reward) in enumerate(rows):
            tau = step + 1
            assert episodes.previous_progress[tau, walk] == previous
            assert episodes.progress[tau, walk] == p
            assert episodes.certificate[tau, walk] == r
            assert (episodes.satisfied[tau, walk].min() > 0) == kept
            assert rewards[step, walk] == pytest.approx(reward, abs=1e-3)


def test_shaping_rewards_the_way_and_adds_up():
    """A straight walk to A earns shape * distance, lambda_2 for A, lambda_3 for the last."""
    task = toy_task("F_[3:3](A)")
    mode = StudioMode(scale=1.0)
    state, schedule = jnp.zeros(2), jnp.array([3] + [0] * 7, jnp.int32)

    @jax.jit
    def start():
        mdp = ground_schedule(task.problem, state, schedule, reserve=1.2)
        return mdp, begin(mode, mdp, state, jnp.float32(0))

    @jax.jit
    def step(mdp, view):
        after = task.robot.step(view.episode.state, jnp.array([1.0, 0.0]))
        return advance(mode, mdp, view, after)

    mdp, view = start()
    total, ends = [], False
    for _ in range(3):
        view, reward, ends = step(mdp, view)
        total.append(float(reward))
    assert bool(ends) and float(view.episode.progress) == 1
    np.testing.assert_allclose(total, [1.0, 1.0, 1.0 + 20 + 20], atol=1e-4)


@pytest.mark.parametrize("mode", [StudioMode(), PaperMode()], ids=["studio", "paper"])
def test_observing_the_initial_state_starts_an_episode(mode):
    """A controller that only ever observes sees what training begins with."""
    task = toy_task("F_[0:6](A) & F_[0:9](B) & G_[0:14](!C)")
    schedule = jnp.array([0, 4] + [0] * 6, jnp.int32)
    constraints = task.problem.formula.constraints.mask.shape[0]

    @jax.jit
    def both(state):
        mdp = ground_schedule(task.problem, state, schedule, reserve=1.2)
        begun = begin(mode, mdp, state, jnp.float32(0))
        episode, sense = mode.observe(mdp, before_start(state, constraints), state)
        return begun, episode, mode.policy_features(mdp, episode, sense)

    for place in (CENTERS["A"], (0.0, 0.0), CENTERS["C"]):
        begun, episode, features = both(jnp.asarray(place, jnp.float32))
        np.testing.assert_array_equal(features, begun.policy)
        assert episode.alive == begun.episode.alive
        if episode.alive:
            assert episode.progress == begun.episode.progress
        np.testing.assert_allclose(episode.robustness, begun.episode.robustness)
