"""Whether a problem can be solved, as far as travel times and places tell."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import jax
import jax.numpy as jnp

from core.compilation import program
from core.task.problem import Problem, initial_states
from core.task.protocols import Array
from core.task.schedules import shortfall, uniform_schedules

STATES, SCHEDULES = 4, 4096
"""Initial states, and schedules of each, by which a problem is judged."""

MOST_MISSED = 0.02
"""Largest share of places in goals that the robot may fail to reach."""


@dataclass(frozen=True)
class Judgement:
    """What is known of a problem before anything is learnt.

    Attributes:
        share: Of uniform schedules that leave time to travel.
        missed: Of places in goals that the robot cannot be placed at.
    """

    share: float
    missed: float

    @property
    def reachable(self) -> bool:
        """Whether the robot can be placed in every goal."""
        return self.missed <= MOST_MISSED


def judge_of(reserve: float, tolerance: float) -> Callable[[Problem], Judgement]:
    """A judge: the same verdict for the same problem.

    Args:
        reserve: planned duration of a leg over the shortest possible one.
        tolerance: distance in [m] up to which a place counts as reached.
    """
    judged = partial(_judged, reserve=reserve, tolerance=tolerance)

    def judge(problem: Problem) -> Judgement:
        return Judgement(*map(float, judged(problem)))

    return judge


@program
def _judged(problem: Problem, *, reserve: float, tolerance: float) -> tuple[Array, Array]:
    """Shares of schedules that leave time to travel, and of places in goals out of reach."""
    draw_key, state_key, place_key = jax.random.split(jax.random.key(0), 3)
    states = initial_states(problem, state_key, count=STATES)
    position = jax.vmap(problem.robot.position)
    starts = jnp.repeat(position(states), SCHEDULES, axis=0)
    schedules = uniform_schedules(problem.formula, draw_key, len(starts))
    short = jax.vmap(partial(shortfall, problem, reserve=reserve))(starts, schedules)
    inside = problem.inside[:, ::4].reshape(-1, starts.shape[-1])
    placed = jax.vmap(problem.robot.place)(jax.random.split(place_key, len(inside)), inside)
    away = jnp.linalg.norm(position(placed) - inside, axis=-1)
    used = jnp.repeat(problem.formula.subgoals.mask, len(inside) // len(problem.inside))
    return (short <= 0).mean(), (used * (away > tolerance)).sum() / used.sum()
