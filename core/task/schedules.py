"""Schedules: values [V] of the formula's time and branch variables, and where they come from.

Few of a tight mission's schedules leave time to travel. They are found by luck, as the best of
many, and by mending: in order of time, each leg that lacks time gets it.

Dimensions: N schedules, V variables.
"""

from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp

from core.task.grounding import FormulaArrays
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.windows import (
    RESERVE,
    Legs,
    Windows,
    lacking_of,
    leg_slack,
    legs_of,
    shortfall_of,
    windows_of,
)

FIRST_DRAWS = 8
"""Uniform schedules of which mending begins with the best."""

MENDINGS = 17
"""Times that a schedule is mended; what the last mending gives is not looked at."""

PREFER_LATER = 0.5
"""How much likelier a later arrival is than an earlier departure, 0 for equally likely."""


@dataclass(frozen=True)
class Search:
    """How schedules are drawn for a controller to choose from."""

    prune: bool = True
    """Whether schedules that leave too little time to travel are passed over."""
    draws: int = 32
    """Uniform schedules of which pruning keeps one."""
    candidates: int = 64
    """Schedules that a controller chooses from in each initial state."""
    reserve: float = RESERVE
    """Planned duration of a leg over the shortest possible one."""


def uniform_schedules(formula: FormulaArrays, key: Array, count: int) -> Array:
    """Schedules [N, V], every variable uniform over its domain."""
    chance = jax.random.uniform(key, (count, formula.low.shape[0]))
    return _integers(chance, formula.low, formula.high)


def feasible_schedules(
    problem: Problem, search: Search, key: Array, states: Array, *, forward: int = 0
) -> Array:
    """One schedule for each of the states [N, n]: [N, V].

    Where the search prunes, one of the least shortfall among `draws` uniform schedules, ties
    broken at random: uniform over those that leave time to travel wherever there are some. One
    that leaves too little is mended. The last `forward` of the schedules begin with only
    `FIRST_DRAWS`, so that more are mended: forward in time, as tight missions need it, whose
    times follow each other closely.
    """
    count, formula = states.shape[0], problem.formula
    if not search.prune:
        return uniform_schedules(formula, key, count)
    draws, variables = search.draws, formula.low.shape[0]
    chance = _chances(key, count, draws, variables)
    drawn = _integers(chance.first, formula.low, formula.high)
    positions = jax.vmap(problem.robot.position)(states)
    of_all = jax.vmap(partial(shortfall, problem, reserve=search.reserve), (None, 0))
    score = jax.vmap(of_all)(positions, drawn) + 1e-3 * chance.tie
    few = jnp.arange(count) >= count - forward
    passed_over = few[:, None] & (jnp.arange(draws) >= min(draws, FIRST_DRAWS))
    best = jnp.where(passed_over, jnp.inf, score).argmin(1)
    mend = partial(_mended, problem, reserve=search.reserve)
    return jax.vmap(mend)(chance.mending, positions, drawn[jnp.arange(count), best])


class _Mending(NamedTuple):
    """What decides one mending: numbers, uniform between 0 and 1."""

    preference: Array  # [..., V]
    amount: Array  # [...]
    other: Array  # [...]
    fresh: Array  # [...]


class _Chances(NamedTuple):
    """What decides schedules: numbers, uniform between 0 and 1."""

    first: Array  # [N, draws, V]
    tie: Array  # [N, draws]
    mending: _Mending  # [N, MENDINGS]


def _chances(key: Array, count: int, draws: int, variables: int) -> _Chances:
    """All drawn in one call: each call of the generator takes long to compile."""
    of_first, of_mending = draws * (variables + 1), MENDINGS * (variables + 3)
    numbers = jax.random.uniform(key, (count, of_first + of_mending))
    first = numbers[:, :of_first].reshape(count, draws, variables + 1)
    last = numbers[:, of_first:].reshape(count, MENDINGS, variables + 3)
    mending = _Mending(last[..., :-3], last[..., -3], last[..., -2], last[..., -1])
    return _Chances(first[..., :-1], first[..., -1], mending)


def _integers(chance: Array, low: Any, high: Any) -> Array:
    """Integers from `low` to `high`, uniform where the chances between 0 and 1 are."""
    return jnp.minimum(low + jnp.floor(chance * (high - low + 1)).astype(jnp.int32), high)


def _mended(
    problem: Problem, chances: _Mending, position: Array, schedule: Array, *, reserve: float
) -> Array:
    """The schedule [V] of least shortfall among those on the way of `MENDINGS` mendings."""

    def mend(carry: tuple[Array, Array, Array], chance: _Mending):
        current, best, least = carry
        windows = windows_of(problem, current)
        legs = legs_of(problem, windows, position, reserve)
        short = shortfall_of(problem.formula, windows, legs)
        best = jnp.where(short < least, current, best)
        following = _mend_once(problem.formula, chance, windows, legs, current)
        return (following, best, jnp.minimum(short, least)), None

    carry = schedule, schedule, jnp.asarray(jnp.inf)
    (_, best, _), _ = jax.lax.scan(mend, carry, chances)
    return best


def _mend_once(
    formula: FormulaArrays, chance: _Mending, windows: Windows, legs: Legs, schedule: Array
) -> Array:
    """The schedule [V] with one variable drawn anew, so that its first short leg has time.

    The leg's time is the start of its target less the end of its source. A variable that it grows
    with is raised, or one that it shrinks with lowered, by at least what is lacking, and rather
    by little than by much. Where no leg is short, the same is done for a requirement that is not
    met. If there is no such variable, any variable is drawn anew.
    """
    lacks = legs.live & (legs.conflict | (legs.needed > legs.available))
    leg = lacks.argmax()
    source, target = windows.order[jnp.maximum(leg - 1, 0)], windows.order[leg]
    behind = jnp.where(leg > 0, windows.end[jnp.maximum(leg - 1, 0)], 0.0)
    available = jnp.where(legs.conflict[leg], windows.start[leg] - behind, legs.available[leg])
    left = jnp.where(leg > 0, 1.0, 0.0) * formula.subgoals.end_weight[source]
    unmet = lacking_of(formula, windows.schedule)
    weight, short = (
        jnp.where(lacks.any(), *pair)
        for pair in (
            (
                formula.subgoals.start_weight[target] - left,
                formula.requirements.weight[unmet.argmax()],
            ),
            (legs.needed[leg] - available, unmet.max()),
        )
    )
    lacking = jnp.maximum(jnp.ceil(short), 1.0).astype(jnp.int32)
    raised, lowered = schedule + lacking, schedule - lacking
    helps = (weight > 0) & (raised <= formula.high) | (weight < 0) & (lowered >= formula.low)
    helps = helps & (lacks.any() | (unmet > 0).any())
    preference = chance.preference + PREFER_LATER * (weight > 0)
    chosen = jnp.where(helps, preference, -1.0).argmax()
    room = jnp.where(weight > 0, formula.high - raised, lowered - formula.low)[chosen]
    further = jnp.floor(chance.amount**2 * (room + 1)).astype(jnp.int32)
    mended = jnp.where(weight > 0, raised + further, lowered - further)[chosen]
    other = _integers(chance.other, jnp.zeros((), jnp.int32), jnp.maximum(formula.variables, 1) - 1)
    fresh = _integers(chance.fresh, formula.low[other], formula.high[other])
    variable, value = (jnp.where(helps.any(), *pair) for pair in ((chosen, other), (mended, fresh)))
    return schedule.at[variable].set(value)


def shortfall(problem: Problem, position: Array, schedule: Array, *, reserve: float) -> Array:
    """Steps [] by which the legs of a schedule [V] from a position [d] are too short."""
    return leg_slack(problem, windows_of(problem, schedule), position, reserve)[1]
