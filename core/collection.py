"""Batches of episodes for learning.

Dimensions: N environments, L steps of a batch, C chains, V variables, f and g features of policy
and critic, n state, m action, d position.
"""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.networks import Parameters
from core.problem import Problem
from core.protocols import Array
from core.rollout import (
    Grounded,
    Setting,
    View,
    advance,
    begin,
    feasible_schedules,
    ground_schedule,
    initial_states,
    score_schedules,
)
from core.sampler import Elite, metropolis_hastings, uniform_schedules


class Batch(NamedTuple):
    """Transitions of an epoch."""

    policy: Array  # [L, N, f]
    critic: Array  # [L + 1, N, g]
    noise: Array  # [L, N, m] standardised deviation of the action from its mean
    reward: Array  # [L, N]
    ended: Array  # [L, N] the transition ended its episode (termination)
    weight: Array  # [L, N] 0 for transitions out of a state that had already failed
    position: Array  # [L + 1, N, d] of every state met
    schedule: Array  # [N, V] of the first episode of each environment
    robustness: Array  # [N] running robustness of the first episode
    success: Array  # [N] whether it succeeded
    chains: Array  # [C, V] where the chains stand


def mixed_schedules(
    setting: Setting,
    problem: Problem,
    parameters: Parameters,
    chains: Array,
    elite: Elite,
    key: Array,
    states: Array,
) -> tuple[Array, Array]:
    """Hybrid sampling (Alg. 1): schedules [N, V] for an epoch's episodes, and the new chains."""
    algorithm = setting.algorithm
    uniform_key, restart_key, chain_key = jax.random.split(key, 3)
    guided, elites = algorithm.count_mcmc, algorithm.count_elite
    uniform = algorithm.environments - guided - elites
    parts = [feasible_schedules(setting, problem, uniform_key, states[:uniform])]
    if guided:
        at = states[uniform : uniform + guided]
        if not algorithm.persistent_chains:
            chains = uniform_schedules(problem.formula, restart_key, guided)

        def log_density(schedules):
            value, shortfall = score_schedules(setting, problem, parameters, at, schedules)
            return algorithm.preference(value, shortfall)

        result = metropolis_hastings(
            log_density,
            problem.formula,
            chain_key,
            chains,
            steps=algorithm.mcmc_steps,
            warmup=algorithm.mcmc_warmup,
            strides=algorithm.mcmc_strides,
        )
        chains = result.last
        parts.append(result.last if algorithm.persistent_chains else result.best)
    if elites:
        parts.append(elite.schedules[:elites])
    return jnp.concatenate(parts), chains


def collect(
    setting: Setting,
    problem: Problem,
    parameters: Parameters,
    chains: Array,
    elite: Elite,
    key: Array,
) -> Batch:
    """A batch of L steps in N environments.

    Each environment starts with an episode from the initial set. When it ends, the next one
    begins at once, drawn from a pool of starts; a share of the pool are exploring starts, at the
    completion of a random subgoal or, for robots that ask for it, within a stay.
    """
    state_key, schedule_key, pool_key, noise_key, slot_key = jax.random.split(key, 5)
    count, steps = setting.algorithm.environments, setting.steps
    states = initial_states(setting, problem, state_key, count)
    schedules, chains = mixed_schedules(
        setting, problem, parameters, chains, elite, schedule_key, states
    )
    positions = jax.vmap(setting.robot.position)(states)
    grounded = jax.vmap(ground_schedule, (None, None, 0, 0))(setting, problem, positions, schedules)
    pool = _start_pool(setting, problem, grounded, pool_key, states)
    noise = jax.random.normal(noise_key, (steps, count, setting.robot.action_size))
    slots = jax.random.randint(slot_key, (steps, count), count, 2 * count)
    spread = jnp.exp(parameters.log_std)

    def step(carry, inputs):
        view, slot, first, robustness, success = carry
        deviation, next_slot = inputs
        mine = jax.tree.map(lambda leaf: leaf[slot % count], grounded)
        action = setting.networks.action(parameters, view.policy) + spread * deviation
        after, reward, ends = jax.vmap(advance, (None, None, 0, 0, 0))(
            setting, problem, mine, view, action
        )
        alive = view.episode.alive > 0
        ends = ends | ~alive
        finished = first & ends
        robustness = jnp.where(finished, after.episode.robustness, robustness)
        reached = jax.vmap(setting.algorithm.mode.succeeded)(mine.windows, after.episode)
        success = jnp.where(finished, reached, success)
        position = jax.vmap(setting.robot.position)(after.episode.state)
        fresh = jax.tree.map(lambda leaf: leaf[next_slot], pool)
        following = jax.tree.map(lambda new, old: _where(ends, new, old), fresh, after)
        slot = jnp.where(ends, next_slot, slot)
        output = (view.policy, view.critic, reward * alive, ends, alive, position)
        return (following, slot, first & ~ends, robustness, success), output

    start = jax.tree.map(lambda leaf: leaf[:count], pool)
    carry = (
        start,
        jnp.arange(count),
        jnp.ones(count, bool),
        start.episode.robustness,
        jnp.zeros(count, bool),
    )
    carry, (policy, critic, reward, ended, weight, position) = jax.lax.scan(
        step, carry, (noise, slots)
    )
    critic = jnp.concatenate([critic, carry[0].critic[None]])
    return Batch(
        policy,
        critic,
        noise,
        reward,
        ended,
        weight.astype(jnp.float32),
        jnp.concatenate([positions[None], position]),
        schedules,
        carry[3],
        carry[4],
        chains,
    )


def collect_layouts(
    setting: Setting,
    problems: Problem,
    parameters: Parameters,
    chains: Array,
    elite: Elite,
    key: Array,
) -> Batch:
    """A batch whose environments are dealt to M layouts, stacked [M, ...] in `problems`."""
    count = setting.algorithm.layouts
    dealt = replace(
        setting.algorithm, environments=setting.algorithm.environments // count, layouts=1
    )
    axes = (1,) * 7 + (0,) * 4  # of the layouts in a batch: after time, where there is time
    batch = jax.vmap(
        partial(collect, setting._replace(algorithm=dealt)),
        (0, None, 0, None, 0),
        Batch._make(axes),
    )(
        problems,
        parameters,
        chains.reshape(count, dealt.count_mcmc, -1),
        elite,
        jax.random.split(key, count),
    )

    def merged(leaf: Array, axis: int) -> Array:
        return leaf.reshape(*leaf.shape[:axis], -1, *leaf.shape[axis + 2 :])

    return Batch(*map(merged, batch, axes))


def _where(mask: Array, new: Array, old: Array) -> Array:
    return jnp.where(mask.reshape(mask.shape + (1,) * (old.ndim - 1)), new, old)


def _start_pool(
    setting: Setting, problem: Problem, grounded: Grounded, key: Array, states: Array
) -> View:
    """2N starts: the epoch's own, then as many of which a share are exploring starts."""
    count = states.shape[0]
    within_stays = setting.algorithm.mode.gradual_stays

    def explore(one: Grounded, state, start_key):
        rank_key, sample_key, place_key, choice_key = jax.random.split(start_key, 4)
        windows = one.windows
        last = windows.count - (0 if within_stays else 1)
        rank = jax.random.randint(rank_key, (), 0, jnp.maximum(last, 1))
        sample = jax.random.randint(sample_key, (), 0, problem.inside.shape[1])
        placed = setting.robot.place(place_key, problem.inside[windows.order[rank], sample])
        chosen = jax.random.uniform(choice_key) < setting.algorithm.mode.exploring
        tau = windows.end[rank]
        if within_stays:
            left = jax.random.uniform(jax.random.fold_in(choice_key, 1))
            tau = tau - jnp.round(left * (tau - windows.start[rank]))
            chosen &= tau < windows.last
        else:
            chosen &= windows.count > 1
        tau = jnp.where(chosen, tau, 0.0)
        return jnp.where(chosen, placed, state), tau

    keys = jax.random.split(key, count)
    explored, tau = jax.vmap(explore)(grounded, states, keys)
    twice = jax.tree.map(lambda leaf: jnp.concatenate([leaf, leaf]), grounded)
    return jax.vmap(begin, (None, None, 0, 0, 0))(
        setting,
        problem,
        twice,
        jnp.concatenate([states, explored]),
        jnp.concatenate([jnp.zeros(count), tau]),
    )
