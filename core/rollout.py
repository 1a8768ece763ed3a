"""Episodes: batches for learning, deterministic rollouts for verdicts, the critic's choice.

Pure functions over a static `Setting`; `core.programs` compiles them.

Dimensions: N environments, L steps of a batch, P starts in the pool, R rollouts, K candidates,
V variables, f and g features of policy and critic, n state, m action, d position.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from core.algorithm import Algorithm
from core.episode import Episode
from core.networks import Networks, Parameters, make_networks
from core.problem import Problem
from core.protocols import Array, Robot, World
from core.sampler import Elite, metropolis_hastings, travelable_schedules, uniform_schedules
from core.windows import Windows, leg_slack, windows_of


class Setting(NamedTuple):
    """Everything that is fixed when a program is compiled."""

    robot: Robot
    world: World
    algorithm: Algorithm
    steps: int

    @property
    def networks(self) -> Networks:
        """Actor and critic of the algorithm."""
        return make_networks(self.algorithm.hidden, self.robot.action_size)


class Grounded(NamedTuple):
    """A schedule's windows and the reserve of its legs from one initial position."""

    windows: Windows
    slack: Array  # [G]
    shortfall: Array  # []


class View(NamedTuple):
    """An episode with what it perceives."""

    episode: Episode
    sense: Any
    policy: Array  # [f]
    critic: Array  # [g]


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


def ground_schedule(setting: Setting, problem: Problem, position: Array, schedule) -> Grounded:
    """Windows and reserve of one schedule [V] from a position [d]."""
    windows = windows_of(problem, schedule)
    slack, shortfall = leg_slack(
        setting.robot, setting.world, problem, windows, position, setting.algorithm.reserve
    )
    return Grounded(windows, slack, shortfall)


def begin(setting: Setting, problem: Problem, grounded: Grounded, state: Array, tau) -> View:
    """Episode of one schedule from a state [n] at step tau."""
    mode = setting.algorithm.mode
    episode, sense = mode.begin(setting.robot, setting.world, problem, grounded.windows, state, tau)
    return _view(setting, problem, grounded, episode, sense)


def advance(
    setting: Setting, problem: Problem, grounded: Grounded, view: View, action: Array
) -> tuple[View, Array, Array]:
    """One step of one episode: the next view, the reward and whether the episode ends."""
    episode, sense, reward, ends = setting.algorithm.mode.advance(
        setting.robot,
        setting.world,
        problem,
        grounded.windows,
        view.episode,
        view.sense,
        action,
    )
    return _view(setting, problem, grounded, episode, sense), reward, ends


def _view(setting: Setting, problem: Problem, grounded: Grounded, episode, sense) -> View:
    mode, windows = setting.algorithm.mode, grounded.windows
    policy = mode.policy_features(setting.robot, problem, windows, episode, sense)
    critic = mode.critic_features(
        problem, windows, grounded.slack, grounded.shortfall, episode, sense, policy
    )
    return View(episode, sense, policy, critic)


def score_schedules(
    setting: Setting, problem: Problem, parameters: Parameters, states: Array, schedules: Array
) -> tuple[Array, Array]:
    """V(s_0, t) [N] in units of the unscaled reward, and the shortfall [N] of each schedule.

    Args:
        setting: what is compiled for.
        problem: the grounded task.
        parameters: weights of both networks.
        states: initial states [N, n].
        schedules: schedules [N, V].
    """

    def features(state, schedule):
        position = setting.robot.position(state)
        grounded = ground_schedule(setting, problem, position, schedule)
        view = begin(setting, problem, grounded, state, jnp.float32(0))
        return view.critic, grounded.shortfall

    critic, shortfall = jax.vmap(features)(states, schedules)
    scale = setting.algorithm.mode.scale
    return setting.networks.value(parameters, critic) / scale, shortfall


def initial_states(setting: Setting, problem: Problem, key: Array, count: int) -> Array:
    """States [N, n] at rest in the initial set."""

    def one(state_key):
        position_key, rest_key = jax.random.split(state_key)
        position = setting.world.sample_initial(problem.world, position_key)
        return setting.robot.rest(rest_key, position)

    return jax.vmap(one)(jax.random.split(key, count))


def feasible_schedules(setting: Setting, problem: Problem, key: Array, states: Array) -> Array:
    """One schedule [N, V] for each state, uniform over those that leave time to travel."""
    algorithm, count = setting.algorithm, states.shape[0]
    if not algorithm.prune:
        return uniform_schedules(problem.formula, key, count)
    positions = jax.vmap(setting.robot.position)(states)
    repeated = jnp.repeat(positions, algorithm.prune_candidates, axis=0)

    def shortfall(schedules):
        ground = jax.vmap(ground_schedule, (None, None, 0, 0))
        return ground(setting, problem, repeated, schedules).shortfall

    return travelable_schedules(problem.formula, shortfall, key, count, algorithm.prune_candidates)


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
            return value - (10.0 * shortfall if algorithm.prune else 0.0)

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
    completion of a random subgoal.
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


def _where(mask: Array, new: Array, old: Array) -> Array:
    return jnp.where(mask.reshape(mask.shape + (1,) * (old.ndim - 1)), new, old)


def _start_pool(
    setting: Setting, problem: Problem, grounded: Grounded, key: Array, states: Array
) -> View:
    """2N starts: the epoch's own, then as many of which a share are exploring starts."""
    count = states.shape[0]

    def explore(one: Grounded, state, start_key):
        rank_key, sample_key, place_key, choice_key = jax.random.split(start_key, 4)
        windows = one.windows
        rank = jax.random.randint(rank_key, (), 0, jnp.maximum(windows.count - 1, 1))
        sample = jax.random.randint(sample_key, (), 0, problem.inside.shape[1])
        placed = setting.robot.place(place_key, problem.inside[windows.order[rank], sample])
        chosen = jax.random.uniform(choice_key) < setting.algorithm.mode.exploring
        chosen &= windows.count > 1
        tau = jnp.where(chosen, windows.end[rank], 0.0)
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


class Rollout(NamedTuple):
    """Deterministic rollouts."""

    states: Array  # [L + 1, R, n]
    actions: Array  # [L, R, m] as the policy gave them, before clipping
    margins: Array  # [L + 1, R, A] margins of the atoms [m]


def roll_out(
    setting: Setting, problem: Problem, parameters: Parameters, states: Array, schedules: Array
) -> Rollout:
    """Carry out schedules [R, V] from states [R, n] with the mean action."""
    positions = jax.vmap(setting.robot.position)(states)
    grounded = jax.vmap(ground_schedule, (None, None, 0, 0))(setting, problem, positions, schedules)
    start = jax.vmap(begin, (None, None, 0, 0, None))(
        setting, problem, grounded, states, jnp.float32(0)
    )

    def step(view, _):
        action = setting.networks.action(parameters, view.policy)
        after, _, _ = jax.vmap(advance, (None, None, 0, 0, 0))(
            setting, problem, grounded, view, action
        )
        return after, (after.episode.state, action)

    _, (visited, actions) = jax.lax.scan(step, start, None, length=setting.steps)
    visited = jnp.concatenate([states[None], visited])
    flat = visited.reshape(-1, visited.shape[-1])
    margins, _ = jax.vmap(
        lambda x: setting.world.margins(problem.world, setting.robot.position(x))
    )(flat)
    return Rollout(visited, actions, margins.reshape(*visited.shape[:2], -1))


def choose_schedules(
    setting: Setting, problem: Problem, parameters: Parameters, key: Array, states: Array
) -> tuple[Array, Array]:
    """The critic's choice for each state [R, n]: schedules [R, V] and their values [R].

    Of K candidates drawn for each state, the one of highest V(s_0, t).
    """
    count, candidates = states.shape[0], setting.algorithm.choice_candidates
    draw_key, deal_key = jax.random.split(key)
    drawn = feasible_schedules(
        setting, problem, draw_key, jnp.repeat(states, max(1, candidates // 8), axis=0)
    )
    dealt = drawn[jax.random.randint(deal_key, (count, candidates), 0, drawn.shape[0])]
    value, shortfall = score_schedules(
        setting,
        problem,
        parameters,
        jnp.repeat(states, candidates, axis=0),
        dealt.reshape(count * candidates, -1),
    )
    if setting.algorithm.prune:
        value = value - 10.0 * shortfall
    value = value.reshape(count, candidates)
    best = value.argmax(1)
    row = jnp.arange(count)
    return dealt[row, best], value[row, best]
