"""A task grounded in a scene: everything a compiled program takes as data."""

from dataclasses import dataclass, field
from functools import partial
from typing import Any, cast

import jax
import jax.numpy as jnp

from core.task.grounding import FormulaArrays
from core.task.inequalities import Inequalities, with_inequalities
from core.task.protocols import Array, BodiedRobot, MovingWorld, Robot, World
from core.task.sites import Sites

SAMPLES_INSIDE = 64
"""Positions kept per subgoal for exploring starts."""


@jax.tree_util.register_dataclass
@dataclass(frozen=True)
class Problem:
    """A robot, the world it moves in, and formula and scene as padded arrays.

    A pytree: robot and world are static, everything else is data. Another formula or scene is
    another argument to the same compiled program.

    G subgoals, d position, S samples, M = 2^D combinations of closed doors.
    """

    robot: Robot = field(metadata={"static": True})
    world: World = field(metadata={"static": True})
    formula: FormulaArrays
    data: Any
    """The world's own arrays."""
    inside: Array
    """Positions [G, S, d] that satisfy each subgoal's predicate [m]."""
    center: Array
    """The deepest of them [G, d]."""
    legs: Array
    """Geodesic distances [M, G, G] from one subgoal's region to another's [m]."""
    on_body: Array | None = None
    """[A] 1 for atoms that the whole body is held against; None: its position decides all."""
    between: Array | None = None
    """Parts [S] of a step that have gone by where constraints are looked at, too, each in (0, 1).

    None where only steps count."""
    inequalities: Inequalities | None = None
    """Predicates of the state, whose atoms come after the regions'; None where there are none."""
    sites: Sites | None = None
    """Where subgoals are, step by step; None where no region moves."""


def to_device(problem: Problem) -> Problem:
    """All leaves as strongly typed JAX arrays, so that no call differs in weak types."""
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, leaf.dtype), problem)


def data_at(problem: Problem, step: Array | float | None) -> Any:
    """The world's data at a step of the problem, or between two.

    Raises:
        ValueError: no step is given, but regions move.
    """
    if problem.sites is None:
        return problem.data
    if step is None:
        raise ValueError("regions move: margins and ways are those at a step, but none is given")
    return cast(MovingWorld, problem.world).at(problem.data, problem.sites.since + step)


def atom_margins(
    problem: Problem, state: Array, step: Array | float | None = None
) -> tuple[Array, Array]:
    """Margins of the atoms [A] in [m] in a state [n], and their gradients [A, d].

    Where regions move, they are where they are at a step, which may be no whole number; a problem
    in which nothing moves needs none.

    In general, margins of the robot's position. Atoms that are `on_body` are entered as soon as any
    ball of the body touches them: the maximum, over position and balls, of margin plus radius.
    Predicates of the state have margins and gradients of their own (`core.task.inequalities`).
    """
    found = _region_margins(problem, state, step)
    if problem.inequalities is None:
        return found
    return with_inequalities(problem.inequalities, problem.robot, state, found)


def _region_margins(
    problem: Problem, state: Array, step: Array | float | None
) -> tuple[Array, Array]:
    robot, margins_at = problem.robot, partial(problem.world.margins, data_at(problem, step))
    margin, gradient = margins_at(robot.position(state))
    if problem.on_body is None:
        return margin, gradient
    centers, radii = cast(BodiedRobot, robot).body(state)
    margins, gradients = jax.vmap(margins_at)(centers)
    margins = jnp.concatenate([margin[None], margins + radii[:, None]])
    gradients = jnp.concatenate([gradient[None], gradients])
    deepest = jnp.where(problem.on_body > 0, margins.argmax(0), 0)
    atom = jnp.arange(margin.shape[0])
    return margins[deepest, atom], gradients[deepest, atom]


def margins_between(problem: Problem, before: Array, after: Array, step: Array) -> Array:
    """mu_ext [S, A + P] in the states between two states [n], where the problem looks there.

    The second is that of a step, the first that of the step before.
    """
    assert problem.between is not None
    states = before + problem.between[:, None] * (after - before)
    if problem.sites is None:
        return jax.vmap(lambda state: extended_margins(problem, state)[0])(states)
    times = step - 1 + problem.between
    return jax.vmap(lambda state, time: extended_margins(problem, state, time)[0])(states, times)


def extended_margins(
    problem: Problem, state: Array, step: Array | float | None = None
) -> tuple[Array, Array]:
    """Margins of atoms and compound predicates: mu_ext [A + P] [m] and gradients [A + P, d].

    A compound predicate is max over its clauses of min over its signed atoms; its gradient is
    that of the deciding atom.
    """
    margin, gradient = atom_margins(problem, state, step)
    formula = problem.formula
    signed = formula.clause_sign * margin[formula.clause_atom]
    literal = jnp.where(formula.clause_sign == 0, jnp.inf, signed)
    clause = literal.min(-1)
    used = (formula.clause_sign != 0).any(-1)
    value = jnp.where(used, clause, -jnp.inf).max(-1)
    best = jnp.where(used, clause, -jnp.inf).argmax(-1)
    row = jnp.arange(best.shape[0])
    decisive = literal[row, best].argmin(-1)
    atom = formula.clause_atom[row, best, decisive]
    sign = formula.clause_sign[row, best, decisive]
    compound_gradient = sign[:, None] * gradient[atom]
    value = jnp.where(used.any(-1), value, 0.0)
    return jnp.concatenate([margin, value]), jnp.concatenate([gradient, compound_gradient])


def closed_doors(problem: Problem, start: Array, end: Array, tau: Array) -> Array:
    """Index of the combination of doors that are closed at the next step.

    Args:
        problem: the grounded task.
        start: first steps of the constraints' windows [C].
        end: last steps [C].
        tau: current step.
    """
    closed = (start <= tau + 1) & (tau + 1 <= end)
    weight = problem.formula.door * closed
    doors = problem.legs.shape[0].bit_length() - 1
    bits = jnp.stack([(weight == 2**i).any() * 2**i for i in range(doors)])
    return bits.sum().astype(jnp.int32)


def trace_margins(problem: Problem, states: Array) -> Array:
    """Margins of the atoms [L, R, A] in states [L, R, n] of the steps 0 to L - 1, in [m]."""
    if problem.sites is not None:
        at_step = jax.vmap(lambda state, step: atom_margins(problem, state, step)[0], (0, None))
        return jax.vmap(at_step)(states, jnp.arange(states.shape[0], dtype=jnp.float32))
    flat = states.reshape(-1, states.shape[-1])
    margins, _ = jax.vmap(partial(atom_margins, problem))(flat)
    return margins.reshape(*states.shape[:2], -1)


def initial_states(problem: Problem, key: Array, *, count: int) -> Array:
    """States [N, n] at rest in the initial set."""

    def one(state_key: Array) -> Array:
        position_key, rest_key = jax.random.split(state_key)
        position = problem.world.sample_initial(problem.data, position_key)
        return problem.robot.rest(rest_key, position)

    return jax.vmap(one)(jax.random.split(key, count))
