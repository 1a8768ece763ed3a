"""The least value of state formulas on the way from each step to the next.

Between steps k and k + 1 the state goes along a straight line, x(k + s) = (1 - s) x_k + s x_{k+1}:
what explicit Euler says of a derivative that is held for a step, and joints at constant speed do.
The true physics of a robot that has one is known at the steps only; the line stands in for it.

A step is looked at in `SUBSTEPS` places at least. Margins change by no more than the robot (or the
farthest moving point of its body) travels: on a part of length l that has the values f and g at
its ends, a formula is at least (f + g - l) / 2. Parts on which that leaves the sign open are
halved until it does not, or the doubt is below `DOUBT`. So no obstacle is too thin to be seen.
Where regions move, they too go along straight lines between the steps, and what counts is how far
the robot travels as seen from any of them: no wall is too fast. Predicates of the state change by
no more than their scaled quantities.

Dimensions: R rollouts, T steps, K state formulas, A atoms, n state, M parts, P points of a body.
"""

from collections.abc import Sequence
from typing import NamedTuple, cast

import jax
import jax.numpy as jnp
import numpy as np

from core.compilation import program
from core.stl import Formula, robustness_signal
from core.task.inequalities import scaled_quantities
from core.task.problem import Problem, atom_margins, data_at
from core.task.protocols import Array, BodiedRobot, MovingWorld
from core.task.task import Task

SUBSTEPS = 8
"""Parts of a step that are looked at whatever the robot does there."""

DOUBT = 1e-4
"""Depth [m] by which a state formula may fail unseen between two places that were looked at."""

HALVINGS = 16

ROWS = 1024
"""States that are looked at in one call of the compiled program."""

MOST_NUMBERS = 4_000_000
"""Margins that are kept at once."""


class Sweep(NamedTuple):
    """State formulas along the steps."""

    value: np.ndarray  # [R, T, K] least from step k to step k + 1 [m]
    share: np.ndarray  # [R, T, K] part of the step that has gone by there, from 0 to 1


class Looked(NamedTuple):
    """What is seen in some states."""

    values: np.ndarray  # [..., K] of the state formulas [m]
    points: np.ndarray  # [..., P, d] by whose way margins change at most [m]


def swept(task: Task, states: np.ndarray, predicates: Sequence[Formula]) -> Sweep:
    """The sweep of state formulas along traces.

    Args:
        task: whose robot and regions are meant.
        states: [R, T + 1, n].
        predicates: state formulas [K] over the task's atoms.
    """
    states = np.asarray(states, np.float32)
    each = max(1, MOST_NUMBERS // (states.shape[1] * SUBSTEPS * len(task.grounding.atoms)))
    parts = [
        _swept(task, states[first : first + each], predicates)
        for first in range(0, len(states), each)
    ]
    return Sweep(*map(np.concatenate, zip(*parts, strict=True)))


def look(
    task: Task, states: np.ndarray, times: np.ndarray, predicates: Sequence[Formula]
) -> Looked:
    """Values of state formulas [K] in states [..., n].

    Args:
        task: whose robot and regions are meant.
        states: of traces.
        times: of the states, in steps; they are broadcast.
        predicates: state formulas [K] over the task's atoms.
    """
    flat = states.reshape(-1, states.shape[-1])
    clock = np.broadcast_to(np.asarray(times, np.float32), states.shape[:-1]).reshape(-1)
    rows = [
        _look(task.problem, flat[i : i + ROWS], clock[i : i + ROWS])
        for i in range(0, len(flat), ROWS)
    ]
    margins, points = map(np.concatenate, zip(*rows, strict=True))
    names = task.grounding.atoms
    atoms = margins[:, None, : len(names)]
    values = np.empty((len(flat), len(predicates)), np.float32)
    for column, each in enumerate(predicates):
        values[:, column] = np.asarray(robustness_signal(each, atoms, names))[:, 0]
    shape = states.shape[:-1]
    return Looked(values.reshape(*shape, -1), points.reshape(*shape, *points.shape[1:]))


def _swept(task: Task, states: np.ndarray, predicates: Sequence[Formula]) -> Sweep:
    rollouts, steps = states.shape[0], states.shape[1] - 1
    share = np.arange(SUBSTEPS, dtype=np.float32) / SUBSTEPS
    change = np.diff(states, axis=1)
    fine = states[:, :-1, None] + share[:, None] * change[:, :, None]
    fine = np.concatenate([fine.reshape(rollouts, steps * SUBSTEPS, -1), states[:, -1:]], 1)
    times = np.arange(steps * SUBSTEPS + 1, dtype=np.float32) / SUBSTEPS
    seen = look(task, fine, times, predicates)
    inside = np.arange(steps)[:, None] * SUBSTEPS + np.arange(SUBSTEPS + 1)
    values, points = seen.values[:, inside], seen.points[:, inside]  # [R, T, SUBSTEPS + 1, ...]
    least = values.argmin(2)
    found = Sweep(values.min(2), least / np.float32(SUBSTEPS))
    _refine(task, predicates, states, found, values, points)
    return found


class _Parts(NamedTuple):
    """Parts of steps, of equal duration."""

    step: np.ndarray  # [M, 2] rollout and step
    share: np.ndarray  # [M] of the step, where the part begins
    low: Looked  # [M, ...] where it begins
    high: Looked  # [M, ...] where it ends

    def kept(self, rows: np.ndarray) -> "_Parts":
        """Some of the parts."""
        low, high = (Looked(*(field[rows] for field in end)) for end in (self.low, self.high))
        return _Parts(self.step[rows], self.share[rows], low, high)


def _refine(  # noqa: PLR0913
    task: Task,
    predicates: Sequence[Formula],
    states: np.ndarray,
    found: Sweep,
    values: np.ndarray,
    points: np.ndarray,
) -> None:
    """Halve the parts that leave the sign of a sweep open; what is found goes into the sweep."""
    rollout, step, part = np.indices(values.shape[:3])[:, :, :, :-1].reshape(3, -1)
    ends = (
        Looked(values[rollout, step, part + i], points[rollout, step, part + i]) for i in (0, 1)
    )
    parts = _Parts(np.stack([rollout, step], 1), part / np.float32(SUBSTEPS), *ends)
    length = np.float32(1 / SUBSTEPS)
    for _ in range(HALVINGS):
        parts = parts.kept(_open(parts, found))
        if not len(parts.step):
            return
        length = length / 2
        share = parts.share + length
        before, after = (states[parts.step[:, 0], parts.step[:, 1] + i] for i in (0, 1))
        between = before + share[:, None] * (after - before)
        middle = look(task, between, parts.step[:, 1] + share, predicates)
        _lower(found, parts.step, share, middle.values)
        first = parts._replace(high=middle)
        second = parts._replace(share=share, low=middle)
        parts = jax.tree.map(lambda one, other: np.concatenate([one, other]), first, second)


def _open(parts: _Parts, found: Sweep) -> np.ndarray:
    """Which parts [M] may make a sweep negative that is not negative yet."""
    travelled = np.linalg.norm(parts.high.points - parts.low.points, axis=-1).max(-1)
    bound = (parts.low.values + parts.high.values - travelled[:, None]) / 2
    settled = found.value[parts.step[:, 0], parts.step[:, 1]] < 0
    return (~settled & (bound < -DOUBT)).any(1)


def _lower(found: Sweep, step: np.ndarray, share: np.ndarray, values: np.ndarray) -> None:
    """Take over values [M, K] at a part of some steps where they are less than what is known."""
    rows = step[:, 0], step[:, 1]
    known = found.value[rows]
    np.minimum.at(found.value, rows, values)
    part, column = np.nonzero((values < known) & (values == found.value[rows]))
    found.share[step[part, 0], step[part, 1], column] = share[part]


def _look(problem: Problem, states: np.ndarray, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Margins [M, A] and points [M, P, d] in M <= `ROWS` states [M, n] at times [M]."""
    missing = ROWS - len(states)
    padded = np.concatenate([states, np.repeat(states[-1:], missing, 0)])
    clock = None  # of regions that stand still, the time tells nothing
    if problem.sites is not None:
        clock = jnp.asarray(np.append(times, np.repeat(times[-1:], missing)), jnp.float32)
    margins, points = _seen(problem, jnp.asarray(padded, jnp.float32), clock)
    return np.asarray(margins)[: len(states)], np.asarray(points)[: len(states)]


@program
def _seen(problem: Problem, states: Array, times: Array | None) -> tuple[Array, Array]:
    """Margins [M, A] of the atoms and points [M, P, d] of the body in states [M, n] at times [M].

    Where regions move, points are given as they are seen from each of them.
    """

    def one(state: Array, time: Array | None) -> tuple[Array, Array]:
        margins, _ = atom_margins(problem, state, time)
        points = problem.robot.position(state)[None]
        if problem.on_body is not None:
            centers, _ = cast(BodiedRobot, problem.robot).body(state)
            points = jnp.concatenate([points, centers])
        if problem.sites is not None:
            moved = cast(MovingWorld, problem.world).displacements(data_at(problem, time))
            points = (points[:, None] - moved).reshape(-1, points.shape[-1])
        if problem.inequalities is not None:
            quantities = scaled_quantities(problem.inequalities, problem.robot, state)
            apart = jnp.pad(points, ((0, 0), (0, quantities.size)))
            points = jnp.concatenate([apart, jnp.pad(quantities, (points.shape[1], 0))[None]])
        return margins, points

    return jax.vmap(one, (0, None if times is None else 0))(states, times)
