"""How a controller takes pushes: as it was planned, and planned anew after each.

A push moves the robot by a given distance in a random direction, at a random step before its plan
is decided. Speed and posture stay. Both ways take the same pushes. A push may end in an obstacle;
then nothing helps.

Dimensions: R episodes, P pushes, L steps, V variables, n state, m action, d position.
"""

from dataclasses import dataclass
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np

from core.answer import Plan, answer
from core.attempts import tries
from core.controller import Controller
from core.errors import UserError
from core.evaluation import rollout_robustness
from core.replanning import Past, replan
from core.rollout import roll_on
from core.task.moving import move_robot
from core.task.protocols import Array
from core.task.task import Task

ATTEMPTS = 100
"""Directions that are drawn for a push that stays within the box."""


@dataclass(frozen=True)
class Pushes:
    """What happens to each episode.

    Attributes:
        size: Of a push in [m].
        within: (low, high) in [m] of each axis: no push leaves this box.
        count: Pushes in an episode.
        seed: Of their steps and directions.
    """

    size: float
    within: tuple[tuple[float, float], ...]
    count: int = 1
    seed: int = 0


class Withstood(NamedTuple):
    """Robustness of R episodes [m], and what planning anew took."""

    undisturbed: np.ndarray  # [R] of the plans themselves
    as_planned: np.ndarray  # [R] with the pushes, the schedule kept
    anew: np.ndarray  # [R] with the pushes, planned anew after each
    hopeless: np.ndarray  # [R] whether a push itself has made the formula false
    seconds: np.ndarray  # [R * P] of each planning anew


class _Push(NamedTuple):
    step: int
    offset: np.ndarray  # [d] in [m]
    within: tuple[tuple[float, float], ...]


def withstand(task: Task, controller: Controller, states: Array, pushes: Pushes) -> Withstood:
    """Plan from each of the states [R, n], push, and go on both ways.

    Raises:
        UserError: pushes of a size or number that makes no sense.
    """
    if not (0 <= pushes.size < np.inf and pushes.count >= 1):
        raise UserError(
            f"{pushes.count} pushes of {pushes.size} m: the size must be finite and not negative, "
            "the number at least 1"
        )
    plans = [answer(task, controller, state).plan for state in states]
    random = np.random.default_rng(pushes.seed)
    drawn = [_drawn(task, plan, pushes, random) for plan in plans]
    kept = _as_planned(task, controller, plans, drawn)
    hopeless, robustness, seconds = [], [], []
    for plan, own in zip(plans, drawn, strict=True):
        now, lost = plan, False
        for push in own:
            past = Past(_pushed(task, now.states[: push.step + 1], push), now.actions[: push.step])
            found = replan(task, controller, past, now.schedule)
            now, lost = found.plan, lost or found.falsified == push.step
            seconds.append(found.seconds)
        hopeless.append(lost)
        robustness.append(now.robustness)
    undisturbed = np.array([plan.robustness for plan in plans])
    return Withstood(undisturbed, kept, *map(np.array, (robustness, hopeless, seconds)))


def _as_planned(
    task: Task, controller: Controller, plans: list[Plan], drawn: list[tuple[_Push, ...]]
) -> np.ndarray:
    """Robustness [R] where the schedules are kept; in batches of the size that answers use."""
    count, found = tries(task), []
    for first in range(0, len(plans), count):
        batch = np.arange(first, min(first + count, len(plans)))
        rows = np.resize(batch, count)  # filled up by repeats
        traces = np.stack([plans[row].states for row in rows], 1)
        schedules = np.stack([plans[row].schedule for row in rows])
        nudges = np.stack([plans[row].nudges for row in rows], 1)
        rollout = None
        for number in range(len(drawn[0])):
            steps = np.array([drawn[row][number].step for row in rows])
            for column, row in enumerate(rows):
                push = drawn[row][number]
                past = _pushed(task, traces[: push.step + 1, column], push)
                traces[: push.step + 1, column] = past
            rollout = roll_on(task, controller, traces, steps, schedules, nudges)
            traces = np.array(rollout.states)
        assert rollout is not None
        found.append(rollout_robustness(task, rollout)[: len(batch)])
    return np.concatenate(found)


def _drawn(
    task: Task, plan: Plan, pushes: Pushes, random: np.random.Generator
) -> tuple[_Push, ...]:
    """Pushes in order of time, all before the last window of the plan's subgoals ends."""
    decomposition = task.grounding.decomposition
    goals = decomposition.active_tasks(decomposition.own_values(plan.schedule))
    ends = [end for goal, _, end in goals if any(goal is own for own in task.grounding.subgoals)]
    last = int(np.clip(max(ends, default=task.horizon), 2, task.horizon - 1))
    steps = np.sort(random.integers(1, last, pushes.count))
    return tuple(
        _Push(int(step), _offset(task, plan.states[step], pushes, random), pushes.within)
        for step in steps
    )


def _offset(
    task: Task, state: np.ndarray, pushes: Pushes, random: np.random.Generator
) -> np.ndarray:
    """A push [d] in [m] that keeps a robot in a state [n] within the box, if one is found."""
    low, high = np.array(pushes.within).T
    here = np.asarray(task.robot.position(jnp.asarray(state)))
    offset = np.zeros(here.shape)
    for _ in range(ATTEMPTS):
        way = random.normal(size=here.shape)
        offset = pushes.size * way / np.linalg.norm(way)
        if np.all((low <= here + offset) & (here + offset <= high)):
            break
    return offset


def _pushed(task: Task, states: np.ndarray, push: _Push) -> np.ndarray:
    """States [k + 1, n], the last one pushed."""
    state = jnp.asarray(states[-1], jnp.float32)
    here = np.asarray(task.robot.position(state))
    low, high = np.array(push.within).T
    place = jnp.asarray(np.clip(here + push.offset, low, high), jnp.float32)
    after, _ = move_robot(state, place, robot=task.robot)
    return np.concatenate([states[:-1], np.asarray(after)[None]])
