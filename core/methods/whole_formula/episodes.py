"""Whole episodes of a policy that explores, in the robot's model.

A simulation that breaks down stops where it last was sound: its numbers reach neither memory nor
weights, and its episode has failed.

Dimensions: L steps, N environments, f what is seen, m action, A atoms.
"""

from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import program
from core.evaluation import trace_robustness
from core.mdp.episode import is_sound
from core.methods.whole_formula.policy import Policy, PolicyWeights
from core.task.problem import Problem, initial_states, trace_margins
from core.task.protocols import Array
from core.task.task import Task

LARGEST = 10.0
"""Magnitude of a robustness in robot lengths beyond which it is paid no further."""


class Episodes(NamedTuple):
    """One episode of each environment."""

    seen: Array  # [L + 1, N, f]
    paid: Array  # [L, N] reward of each step, without the robustness at the end
    noise: Array  # [L, N, m] standardised deviation of the action from its mean
    margins: Array  # [L + 1, N, A] [m]
    sound: Array  # [N] whether the simulation did not break down


@program
def explore(
    problem: Problem, weights: PolicyWeights, key: Array, *, policy: Policy, count: int, steps: int
) -> Episodes:
    """Episodes of N = count environments, each of L = steps, with noisy actions."""
    state_key, noise_key = jax.random.split(key)
    states = initial_states(problem, state_key, count=count)
    noise = jax.random.normal(noise_key, (steps, count, problem.robot.action_size))
    deviation = jnp.exp(weights.heads.log_std)
    act = jax.vmap(partial(policy.act, problem, weights))

    def step(carry: tuple[Any, Array, Array], noise: Array):
        memory, state, sound = carry
        acted = act(memory, state)
        after = jax.vmap(problem.robot.step)(state, acted.mean + deviation * noise)
        sound = sound & jax.vmap(is_sound)(after)
        after = jnp.where(sound[:, None], after, state)
        return (acted.memory, after, sound), (acted.seen, acted.paid, state)

    memory = jax.vmap(partial(policy.start, problem, weights))(states)
    carry = memory, states, jnp.ones(count, bool)
    (memory, last, sound), (seen, paid, visited) = jax.lax.scan(step, carry, noise)
    end = act(memory, last)
    return Episodes(
        jnp.concatenate([seen, end.seen[None]]),
        jnp.concatenate([paid[1:], end.paid[None]]),
        noise,
        trace_margins(problem, jnp.concatenate([visited, last[None]])),
        sound,
    )


def verdicts(task: Task, margins: Array, sound: Array) -> np.ndarray:
    """Robustness [N] of the formula on whole episodes in [m]; -inf where a simulation broke down.

    It is evaluated on the host, so that another formula needs no compilation.
    """
    return np.where(np.asarray(sound), trace_robustness(task, np.asarray(margins)), -np.inf)


def reward_of(task: Task, verdict: np.ndarray) -> np.ndarray:
    """What a robustness [N] is worth at the end of an episode [N], in robot lengths."""
    return np.clip(verdict / task.robot.length, -LARGEST, LARGEST).astype(np.float32)
