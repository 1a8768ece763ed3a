"""Batches of episodes for learning.

Dimensions: N environments, L steps of a batch, C chains, V variables, f and g features of policy
and critic, n state, m action, d position.
"""

from dataclasses import replace
from functools import partial
from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.mdp.grounded import AXES, GroundedMdp
from core.mdp.mode import Mode, View, advance, begin, first_views
from core.methods.networks import Parameters, networks_of
from core.methods.tgpo.algorithm import Algorithm
from core.methods.tgpo.controller import schedule_value
from core.methods.tgpo.sampler import Elite, metropolis_hastings
from core.task.problem import Problem, initial_states
from core.task.protocols import Array
from core.task.schedules import feasible_schedules, uniform_schedules
from core.task.sites import inside_at


class Batch(NamedTuple):
    """Transitions of an epoch."""

    policy: Array  # [L, N, f]
    critic: Array  # [L + 1, N, g]
    noise: Array  # [L, N, m] standardised deviation of the action from its mean
    reward: Array  # [L, N]
    ended: Array  # [L, N] the transition ended its episode (termination)
    weight: Array  # [L, N] 0 for transitions out of a state that had already failed
    states: Array  # [L + 1, N, n] every state met
    schedule: Array  # [N, V] of the first episode of each environment
    robustness: Array  # [N] running robustness of the first episode
    success: Array  # [N] whether it succeeded
    chains: Array  # [C, V] where the chains stand
    diverged: Array  # [] simulations that diverged


class Sources(NamedTuple):
    """What a batch is collected with."""

    parameters: Parameters
    chains: Array  # [C, V] where the chains stand
    elite: Elite


def mixed_schedules(
    problem: Problem,
    algorithm: Algorithm,
    sources: Sources,
    key: Array,
    states: Array,
) -> tuple[Array, Array]:
    """Hybrid sampling (Alg. 1): schedules [N, V] for an epoch's episodes, and the new chains."""
    uniform_key, restart_key, chain_key = jax.random.split(key, 3)
    guided, elites = algorithm.count_mcmc, algorithm.count_elite
    uniform = algorithm.environments - guided - elites
    forward = round(algorithm.share_forward * uniform)
    chains, search = sources.chains, algorithm.search
    parts = [feasible_schedules(problem, search, uniform_key, states[:uniform], forward=forward)]
    if guided:
        at = states[uniform : uniform + guided]
        if not algorithm.persistent_chains:
            chains = uniform_schedules(problem.formula, restart_key, guided)
        values = jax.vmap(partial(schedule_value, algorithm, problem, sources.parameters))

        def log_density(schedules: Array) -> Array:
            return algorithm.preference(*values(at, schedules))

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
        parts.append(sources.elite.schedules[:elites])
    return jnp.concatenate(parts), chains


class Plan(NamedTuple):
    """Everything drawn before a batch begins."""

    mdps: GroundedMdp  # [N] of each environment's schedule, without the problem
    pool: View  # [2N] starts: the epoch's own, then those of the episodes that follow
    noise: Array  # [L, N, m] standard normal
    slots: Array  # [L, N] the start that follows an episode which ends at this step
    states: Array  # [N, n] at the beginning
    schedule: Array  # [N, V]
    chains: Array  # [C, V]


class Front(NamedTuple):
    """Where the environments stand between two steps."""

    view: View  # [N]
    slot: Array  # [N] the start of the current episode
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
    states: Array
    diverged: Array


def prepare(
    problem: Problem, sources: Sources, key: Array, *, algorithm: Algorithm, steps: int
) -> tuple[Plan, Front]:
    """Draw schedules, starts and noise, and begin."""
    state_key, schedule_key, pool_key, noise_key, slot_key = jax.random.split(key, 5)
    count = algorithm.environments
    states = initial_states(problem, state_key, count=count)
    schedules, chains = mixed_schedules(problem, algorithm, sources, schedule_key, states)
    mdps, first = first_views(algorithm.mode, problem, states, schedules, algorithm.reserve)
    following = _following_starts(problem, algorithm.mode, mdps, pool_key, states)
    pool = jax.tree.map(lambda one, other: jnp.concatenate([one, other]), first, following)
    noise = jax.random.normal(noise_key, (steps, count, problem.robot.action_size))
    slots = jax.random.randint(slot_key, (steps, count), count, 2 * count)
    front = Front(
        first,
        jnp.arange(count),
        jnp.ones(count, bool),
        first.episode.robustness,
        jnp.zeros(count, bool),
    )
    return Plan(_bare(mdps), pool, noise, slots, states, schedules, chains), front


def explore(
    problem: Problem,
    parameters: Parameters,
    front: Front,
    noise: Array,
    *,
    algorithm: Algorithm,
) -> Array:
    """Noisy actions [N, m]."""
    mean = networks_of(algorithm, problem).action(parameters, front.view.policy)
    return mean + jnp.exp(parameters.log_std) * noise


def settle(
    problem: Problem,
    plan: Plan,
    front: Front,
    states: Array,
    slots: Array,
    *,
    algorithm: Algorithm,
) -> tuple[Front, Transition]:
    """One step of all environments; where an episode ends, the next begins.

    Args:
        problem: the grounded task.
        plan: of the batch.
        front: before the step.
        states: to which the robots have come [N, n].
        slots: the start [N] of the episode that follows one which ends.
        algorithm: of the training.
    """
    count, view, mode = slots.shape[0], front.view, algorithm.mode
    mdps = jax.tree.map(lambda leaf: leaf[front.slot % count], plan.mdps)
    mdps = mdps._replace(problem=problem)
    after, reward, ends = jax.vmap(partial(advance, mode), (AXES, 0, 0))(mdps, view, states)
    alive = view.episode.alive > 0 if mode.early_end else jnp.ones(count, bool)
    ends = ends | ~alive
    finished = front.first & ends
    reached = jax.vmap(mode.succeeded, (AXES, 0))(mdps, after.episode)
    fresh = jax.tree.map(lambda leaf: leaf[slots], plan.pool)
    following = Front(
        jax.tree.map(lambda new, old: _where(ends, new, old), fresh, after),
        jnp.where(ends, slots, front.slot),
        front.first & ~ends,
        jnp.where(finished, after.episode.robustness, front.robustness),
        jnp.where(finished, reached, front.success),
    )
    return following, Transition(
        view.policy,
        view.critic,
        reward * alive,
        ends,
        alive.astype(jnp.float32),
        after.episode.state,
        after.episode.robustness == -jnp.inf,
    )


def finish(plan: Plan, front: Front, transitions: Transition) -> Batch:
    """The batch of L transitions, stacked along the first axis."""
    return Batch(
        transitions.policy,
        jnp.concatenate([transitions.critic, front.view.critic[None]]),
        plan.noise,
        transitions.reward,
        transitions.ended,
        transitions.weight,
        jnp.concatenate([plan.states[None], transitions.states]),
        plan.schedule,
        front.robustness,
        front.success,
        plan.chains,
        transitions.diverged.sum(),
    )


def collect(
    problem: Problem, sources: Sources, key: Array, *, algorithm: Algorithm, steps: int
) -> Batch:
    """A batch of L steps in N environments.

    Each environment starts with an episode from the initial set. When it ends, the next one
    begins at once, drawn from a pool of starts; a share of the pool are exploring starts, at the
    completion of a random subgoal or, for robots that ask for it, within a stay.
    """
    plan, start = prepare(problem, sources, key, algorithm=algorithm, steps=steps)

    def step(front: Front, inputs: tuple[Array, Array]):
        noise, slots = inputs
        action = explore(problem, sources.parameters, front, noise, algorithm=algorithm)
        states = jax.vmap(problem.robot.step)(front.view.episode.state, action)
        return settle(problem, plan, front, states, slots, algorithm=algorithm)

    front, transitions = jax.lax.scan(step, start, (plan.noise, plan.slots))
    return finish(plan, front, transitions)


def collect_layouts(
    problems: Problem, sources: Sources, key: Array, *, algorithm: Algorithm, steps: int
) -> Batch:
    """A batch whose environments are dealt to M layouts, stacked [M, ...] in `problems`."""
    count, chains = algorithm.layouts, sources.chains
    dealt = replace(algorithm, environments=algorithm.environments // count, layouts=1)
    axes = (1,) * 7 + (0,) * 5  # of the layouts in a batch: after time, where there is time
    batch = jax.vmap(
        partial(collect, algorithm=dealt, steps=steps),
        (0, Sources(None, 0, None), 0),  # pyright: ignore[reportArgumentType]
        Batch._make(axes),
    )(
        problems,
        sources._replace(chains=chains.reshape(count, dealt.count_mcmc, chains.shape[-1])),
        jax.random.split(key, count),
    )

    def merged(leaf: Array, axis: int) -> Array:
        return leaf.reshape(*leaf.shape[:axis], -1, *leaf.shape[axis + 2 :])

    fields = [merged(leaf, axis) for leaf, axis in zip(batch[:-1], axes, strict=False)]
    return Batch._make([*fields, batch.diverged.sum()])


def _where(mask: Array, new: Array, old: Array) -> Array:
    return jnp.where(mask.reshape(mask.shape + (1,) * (old.ndim - 1)), new, old)


def _bare(mdps: GroundedMdp) -> GroundedMdp:
    """Without the problem, which is not copied."""
    return mdps._replace(problem=None)  # pyright: ignore[reportArgumentType]


def _following_starts(
    problem: Problem, mode: Mode, mdps: GroundedMdp, key: Array, states: Array
) -> View:
    """N starts [N] of episodes that follow, of which a share are exploring starts."""

    def start_of(mdp: GroundedMdp, state: Array, start_key: Array) -> tuple[Array, Array]:
        rank_key, sample_key, place_key, choice_key, stay_key = jax.random.split(start_key, 5)
        windows = mdp.windows
        last = windows.count - (0 if mode.gradual_stays else 1)
        rank = jax.random.randint(rank_key, (), 0, jnp.maximum(last, 1))
        sample = jax.random.randint(sample_key, (), 0, problem.inside.shape[1])
        placed = problem.robot.place(place_key, problem.inside[windows.order[rank], sample])
        chosen = jax.random.uniform(choice_key) < mode.exploring
        tau = windows.end[rank]
        if mode.gradual_stays:
            left = jax.random.uniform(stay_key)
            tau = tau - jnp.round(left * (tau - windows.start[rank]))
            chosen &= tau < windows.last
        else:
            chosen &= windows.count > 1
        if problem.sites is not None:
            there = inside_at(problem.sites, windows.order[rank], sample, tau)
            placed = problem.robot.place(place_key, there)
        tau = jnp.where(chosen, tau, 0.0)
        return jnp.where(chosen, placed, state), tau

    keys = jax.random.split(key, states.shape[0])
    explored, tau = jax.vmap(start_of, (AXES, 0, 0))(mdps, states, keys)
    return jax.vmap(partial(begin, mode), (AXES, 0, 0))(mdps, explored, tau)
