"""Deterministic rollouts for verdicts, the critic's choice of a schedule, and their pieces.

Pure functions over a static `Setting`; `core.programs` compiles them.

Dimensions: N schedules, R rollouts, L steps, K candidates, V variables, f and g features of
policy and critic, n state, m action, d position, A atoms.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from core.algorithm import Algorithm
from core.episode import Episode
from core.networks import Networks, Parameters, make_networks
from core.problem import Problem, atom_margins
from core.protocols import Array, Robot, World
from core.sampler import travelable_schedules, uniform_schedules
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


class Rollout(NamedTuple):
    """Deterministic rollouts."""

    states: Array  # [L + 1, R, n]
    actions: Array  # [L, R, m] as the policy gave them, before clipping
    margins: Array  # [L + 1, R, A] margins of the atoms [m]


class Course(NamedTuple):
    """R rollouts under way: where they stand and what the policy wants next."""

    grounded: Grounded  # [R]
    view: View  # [R]
    action: Array  # [R, m] mean action, before clipping


def depart(
    setting: Setting, problem: Problem, parameters: Parameters, states: Array, schedules: Array
) -> Course:
    """Rollouts of schedules [R, V] at their initial states [R, n]."""
    positions = jax.vmap(setting.robot.position)(states)
    grounded = jax.vmap(ground_schedule, (None, None, 0, 0))(setting, problem, positions, schedules)
    view = jax.vmap(begin, (None, None, 0, 0, None))(
        setting, problem, grounded, states, jnp.float32(0)
    )
    return Course(grounded, view, setting.networks.action(parameters, view.policy))


def proceed(
    setting: Setting, problem: Problem, parameters: Parameters, course: Course, command: Array
) -> Course:
    """One step of all rollouts; the command is what `step` takes: actions [R, m], as a rule."""
    view, _, _ = jax.vmap(advance, (None, None, 0, 0, 0))(
        setting, problem, course.grounded, course.view, command
    )
    action = setting.networks.action(parameters, view.policy)
    return course._replace(view=view, action=action)


def trace_margins(setting: Setting, problem: Problem, states: Array) -> Array:
    """Margins of the atoms [L, R, A] in states [L, R, n], in [m]."""
    flat = states.reshape(-1, states.shape[-1])
    margins, _ = jax.vmap(partial(atom_margins, setting.robot, setting.world, problem))(flat)
    return margins.reshape(*states.shape[:2], -1)


def roll_out(
    setting: Setting, problem: Problem, parameters: Parameters, states: Array, schedules: Array
) -> Rollout:
    """Carry out schedules [R, V] from states [R, n] with the mean action."""

    def step(course, _):
        after = proceed(setting, problem, parameters, course, course.action)
        return after, (after.view.episode.state, course.action)

    start = depart(setting, problem, parameters, states, schedules)
    _, (visited, actions) = jax.lax.scan(step, start, None, length=setting.steps)
    visited = jnp.concatenate([states[None], visited])
    return Rollout(visited, actions, trace_margins(setting, problem, visited))


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
    value = setting.algorithm.preference(value, shortfall)
    value = value.reshape(count, candidates)
    best = value.argmax(1)
    row = jnp.arange(count)
    return dealt[row, best], value[row, best]
