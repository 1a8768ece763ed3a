"""Sampling of schedules by the critic and from the elite (Sec. 4.3).

Dimensions: N schedules, V variables, K elite capacity.
"""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp

from core.task.grounding import FormulaArrays
from core.task.protocols import Array


class Elite(NamedTuple):
    """The schedules of highest robustness so far."""

    schedules: Array  # [K, V]
    scores: Array  # [K]


class Chains(NamedTuple):
    """Result of Metropolis-Hastings."""

    last: Array  # [N, V] where each chain stands
    best: Array  # [N, V] the highest density that each chain met after its warm-up
    accepted: Array  # [] share of accepted proposals


def metropolis_hastings(
    log_density: Callable[[Array], Array],
    formula: FormulaArrays,
    key: Array,
    start: Array,
    *,
    steps: int,
    warmup: int,
    strides: tuple[int, ...] = (1,),
) -> Chains:
    """Sample schedules from exp(log_density) (Alg. 2).

    A proposal moves one variable by plus or minus one of the strides; a move out of the domain
    is rejected. With strides (1,) this is the paper's proposal. The proposal is symmetric, so
    exp(log_density) is the chains' stationary distribution.

    Args:
        log_density: maps schedules [N, V] to log densities [N], up to a constant.
        formula: domains of the variables.
        key: random key.
        start: where the chains stand [N, V].
        steps: proposals per chain.
        warmup: steps after which `best` begins to be kept.
        strides: possible step lengths.
    """
    count, size = start.shape
    moves = jnp.array([sign * stride for stride in strides for sign in (-1, 1)], jnp.int32)

    def propose(carry, inputs):  # step -1 only evaluates the start: one log_density is compiled
        schedule, density, best, best_density = carry
        step_key, index = inputs
        variable_key, move_key, accept_key = jax.random.split(step_key, 3)
        variable = jax.random.randint(variable_key, (count,), 0, jnp.maximum(formula.variables, 1))
        move = jnp.where(index < 0, 0, jax.random.choice(move_key, moves, (count,)))
        proposal = schedule + jax.nn.one_hot(variable, size, dtype=jnp.int32) * move[:, None]
        inside = ((proposal >= formula.low) & (proposal <= formula.high)).all(-1)
        proposed = log_density(jnp.where(inside[:, None], proposal, schedule))
        chance = jnp.log(jax.random.uniform(accept_key, (count,), minval=1e-12))
        accept = inside & (chance < proposed - density)
        schedule = jnp.where(accept[:, None], proposal, schedule)
        density = jnp.where(accept, proposed, density)
        better = (index >= warmup) & (density > best_density)
        best = jnp.where(better[:, None], schedule, best)
        best_density = jnp.where(better, density, best_density)
        return (schedule, density, best, best_density), accept.mean()

    unknown = jnp.full(count, -jnp.inf)
    inputs = (jax.random.split(key, steps + 1), jnp.arange(-1, steps))
    carry = (start, unknown, start, unknown)
    (last, _, best, _), accepted = jax.lax.scan(propose, carry, inputs)
    return Chains(last, best, accepted[1:].mean())


def update_elite(elite: Elite, schedules: Array, scores: Array, decay: float) -> Elite:
    """Keep the K best of the buffer and the new schedules [N, V] with their scores [N].

    `decay` is subtracted from old scores, so that one lucky episode does not stay forever.
    """
    pool = jnp.concatenate([elite.schedules, schedules])
    values = jnp.concatenate([elite.scores - decay, scores])
    best, index = jax.lax.top_k(values, elite.scores.shape[0])
    return Elite(pool[index], best)
