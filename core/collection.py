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
    diverged: Array  # [] simulations that broke down


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


class Plan(NamedTuple):
    """What is drawn before a batch begins."""

    grounded: Grounded  # [N] each environment's schedule
    pool: View  # [2N] starts: the epoch's own, then those of the episodes that follow
    noise: Array  # [L, N, m] standard normal
    slots: Array  # [L, N] the start that follows an episode which ends at this step
    position: Array  # [N, d] at the beginning
    schedule: Array  # [N, V]
    chains: Array  # [C, V]


class Stage(NamedTuple):
    """Where the environments stand between two steps."""

    view: View  # [N]
    slot: Array  # [N] the start of the present episode
    first: Array  # [N] whether the first episode still lasts
    robustness: Array  # [N] of the first episode
    success: Array  # [N] of the first episode


class Transition(NamedTuple):
    """One step of all environments; the fields are those of `Batch`."""

    policy: Array
    critic: Array
    reward: Array
    ended: Array
    weight: Array
    position: Array
    diverged: Array


def prepare(
    setting: Setting,
    problem: Problem,
    parameters: Parameters,
    chains: Array,
    elite: Elite,
    key: Array,
) -> tuple[Plan, Stage]:
    """Draw schedules, starts and noise, and begin."""
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
    start = jax.tree.map(lambda leaf: leaf[:count], pool)
    stage = Stage(
        start,
        jnp.arange(count),
        jnp.ones(count, bool),
        start.episode.robustness,
        jnp.zeros(count, bool),
    )
    return Plan(grounded, pool, noise, slots, positions, schedules, chains), stage


def explore(setting: Setting, parameters: Parameters, stage: Stage, noise: Array) -> Array:
    """Noisy actions [N, m]."""
    mean = setting.networks.action(parameters, stage.view.policy)
    return mean + jnp.exp(parameters.log_std) * noise


def settle(
    setting: Setting, problem: Problem, plan: Plan, stage: Stage, command: Array, slots: Array
) -> tuple[Stage, Transition]:
    """One step of all environments; where an episode ends, the next begins.

    Args:
        setting: what is compiled for.
        problem: the grounded task.
        plan: of the batch.
        stage: before the step.
        command: what `robot.step` takes: actions [N, m], as a rule.
        slots: the start [N] of the episode that follows one which ends.
    """
    count = slots.shape[0]
    view = stage.view
    mine = jax.tree.map(lambda leaf: leaf[stage.slot % count], plan.grounded)
    after, reward, ends = jax.vmap(advance, (None, None, 0, 0, 0))(
        setting, problem, mine, view, command
    )
    alive = view.episode.alive > 0
    ends = ends | ~alive
    finished = stage.first & ends
    reached = jax.vmap(setting.algorithm.mode.succeeded)(mine.windows, after.episode)
    fresh = jax.tree.map(lambda leaf: leaf[slots], plan.pool)
    following = Stage(
        jax.tree.map(lambda new, old: _where(ends, new, old), fresh, after),
        jnp.where(ends, slots, stage.slot),
        stage.first & ~ends,
        jnp.where(finished, after.episode.robustness, stage.robustness),
        jnp.where(finished, reached, stage.success),
    )
    return following, Transition(
        view.policy,
        view.critic,
        reward * alive,
        ends,
        alive.astype(jnp.float32),
        jax.vmap(setting.robot.position)(after.episode.state),
        after.episode.robustness == -jnp.inf,
    )


def finish(plan: Plan, stage: Stage, transitions: Transition) -> Batch:
    """The batch of L transitions, stacked along the first axis."""
    return Batch(
        transitions.policy,
        jnp.concatenate([transitions.critic, stage.view.critic[None]]),
        plan.noise,
        transitions.reward,
        transitions.ended,
        transitions.weight,
        jnp.concatenate([plan.position[None], transitions.position]),
        plan.schedule,
        stage.robustness,
        stage.success,
        plan.chains,
        transitions.diverged.sum(),
    )


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
    plan, start = prepare(setting, problem, parameters, chains, elite, key)

    def step(stage, inputs):
        noise, slots = inputs
        action = explore(setting, parameters, stage, noise)
        return settle(setting, problem, plan, stage, action, slots)

    stage, transitions = jax.lax.scan(step, start, (plan.noise, plan.slots))
    return finish(plan, stage, transitions)


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
    axes = (1,) * 7 + (0,) * 5  # of the layouts in a batch: after time, where there is time
    batch = jax.vmap(
        partial(collect, setting._replace(algorithm=dealt)),
        (0, None, 0, None, 0),
        Batch._make(axes),
    )(
        problems,
        parameters,
        chains.reshape(count, dealt.count_mcmc, chains.shape[-1]),
        elite,
        jax.random.split(key, count),
    )

    def merged(leaf: Array, axis: int) -> Array:
        return leaf.reshape(*leaf.shape[:axis], -1, *leaf.shape[axis + 2 :])

    fields = [merged(leaf, axis) for leaf, axis in zip(batch[:-1], axes, strict=False)]
    return Batch._make([*fields, batch.diverged.sum()])


def _where(mask: Array, new: Array, old: Array) -> Array:
    return jnp.where(mask.reshape(mask.shape + (1,) * (old.ndim - 1)), new, old)


def _start_pool(
    setting: Setting, problem: Problem, grounded: Grounded, key: Array, states: Array
) -> View:
    """2N starts: the epoch's own, then as many of which a share are exploring starts."""
    count = states.shape[0]
    within_stays = setting.algorithm.mode.gradual_stays

    def start_of(one: Grounded, state, start_key):
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
    explored, tau = jax.vmap(start_of)(grounded, states, keys)
    twice = jax.tree.map(lambda leaf: jnp.concatenate([leaf, leaf]), grounded)
    return jax.vmap(begin, (None, None, 0, 0, 0))(
        setting,
        problem,
        twice,
        jnp.concatenate([states, explored]),
        jnp.concatenate([jnp.zeros(count), tau]),
    )
