"""Schedules: values [V] of the formula's time and branch variables, and where they come from.

Few of a tight mission's schedules leave time to travel. They are found by luck, as the best of
many, and by mending: in order of time, each leg that lacks time gets it.

Dimensions: N schedules, V variables.
"""

from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp

from core.task.grounding import FormulaArrays
from core.task.problem import Problem
from core.task.protocols import Array
from core.task.windows import RESERVE, Legs, Windows, lacking_of, leg_slack, legs_of, windows_of

FIRST_DRAWS = 8
"""Uniform schedules of which mending begins with the best."""

MENDINGS = 16
"""Times that a schedule is mended."""

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
    shape = (count, formula.low.shape[0])
    return jax.random.randint(key, shape, formula.low, formula.high + 1)


def feasible_schedules(problem: Problem, search: Search, key: Array, states: Array) -> Array:
    """One schedule for each of the states [N, n]: [N, V].

    Where the search prunes, one of the least shortfall among `draws` uniform schedules, ties
    broken at random: uniform over those that leave time to travel wherever there are some. One
    that leaves too little is mended.
    """
    return _drawn(problem, search, key, states, search.draws)


def forward_schedules(problem: Problem, search: Search, key: Array, states: Array) -> Array:
    """One schedule for each of the states [N, n]: [N, V], mended forward in time.

    The same from only a few uniform schedules, so that more are mended: those of tight missions,
    whose times follow each other closely.
    """
    return _drawn(problem, search, key, states, min(search.draws, FIRST_DRAWS))


def both_schedules(problem: Problem, search: Search, key: Array, states: Array) -> Array:
    """One schedule for each of the states [N, n]: [N, V], those of the latter half forward."""
    uniform_key, forward_key = jax.random.split(key)
    half = states.shape[0] // 2
    return jnp.concatenate(
        [
            feasible_schedules(problem, search, uniform_key, states[:half]),
            forward_schedules(problem, search, forward_key, states[half:]),
        ]
    )


def _drawn(problem: Problem, search: Search, key: Array, states: Array, draws: int) -> Array:
    """The best of so many uniform schedules, mended: [N, V]."""
    count = states.shape[0]
    if not search.prune:
        return uniform_schedules(problem.formula, key, count)
    draw_key, tie_key, mend_key = jax.random.split(key, 3)
    drawn = uniform_schedules(problem.formula, draw_key, count * draws)
    positions = jax.vmap(problem.robot.position)(states)
    repeated = jnp.repeat(positions, draws, axis=0)
    short = jax.vmap(partial(shortfall, problem, reserve=search.reserve))(repeated, drawn)
    short = short.reshape(count, draws)
    score = short + 1e-3 * jax.random.uniform(tie_key, short.shape)
    best = drawn.reshape(count, draws, -1)[jnp.arange(count), score.argmin(1)]
    keys = jax.random.split(mend_key, count)
    return jax.vmap(partial(_mended, problem, reserve=search.reserve))(keys, positions, best)


def _mended(
    problem: Problem, key: Array, position: Array, schedule: Array, *, reserve: float
) -> Array:
    """The schedule [V] of least shortfall among those on the way of `MENDINGS` mendings."""

    def mend(carry: tuple[Array, Array, Array], mend_key: Array):
        current, best, least = carry
        windows = windows_of(problem, current)
        short = leg_slack(problem, windows, position, reserve)[1]
        best = jnp.where(short < least, current, best)
        legs = legs_of(problem, windows, position, reserve)
        following = _mend_once(problem.formula, mend_key, windows, legs, current)
        return (following, best, jnp.minimum(short, least)), None

    keys = jax.random.split(key, MENDINGS)
    carry = schedule, schedule, jnp.asarray(jnp.inf)
    (last, best, least), _ = jax.lax.scan(mend, carry, keys)
    short = shortfall(problem, position, last, reserve=reserve)
    return jnp.where(short < least, last, best)


def _mend_once(
    formula: FormulaArrays, key: Array, windows: Windows, legs: Legs, schedule: Array
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
    which_key, any_key, value_key, fresh_key = jax.random.split(key, 4)
    preference = jax.random.uniform(which_key, helps.shape) + PREFER_LATER * (weight > 0)
    chosen = jnp.where(helps, preference, -1.0).argmax()
    amount = jax.random.uniform(value_key) ** 2
    room = jnp.where(weight > 0, formula.high - raised, lowered - formula.low)[chosen]
    further = jnp.floor(amount * (room + 1)).astype(jnp.int32)
    mended = jnp.where(weight > 0, raised + further, lowered - further)[chosen]
    other = jax.random.randint(any_key, (), 0, jnp.maximum(formula.variables, 1))
    fresh = jax.random.randint(fresh_key, (), formula.low[other], formula.high[other] + 1)
    variable, value = (jnp.where(helps.any(), *pair) for pair in ((chosen, other), (mended, fresh)))
    return schedule.at[variable].set(value)


def shortfall(problem: Problem, position: Array, schedule: Array, *, reserve: float) -> Array:
    """Steps [] by which the legs of a schedule [V] from a position [d] are too short."""
    return leg_slack(problem, windows_of(problem, schedule), position, reserve)[1]
