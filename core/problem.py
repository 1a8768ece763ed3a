"""A task grounded in a scene: everything a compiled program takes as data."""

from typing import Any, NamedTuple, cast

import jax
import jax.numpy as jnp

from core.grounding import COMBINATIONS, FormulaArrays
from core.protocols import Array, BodiedRobot, Robot, World

SAMPLES_INSIDE = 64
"""Positions kept per subgoal for exploring starts."""


class Problem(NamedTuple):
    """Formula and scene as padded arrays.

    G subgoals, d position, S samples, M combinations of closed doors.
    """

    formula: FormulaArrays
    world: Any  # the world's own arrays
    inside: Array  # [G, S, d] positions that satisfy each subgoal's predicate [m]
    center: Array  # [G, d] the deepest of them
    legs: Array  # [M, G, G] geodesic distance from one subgoal's region to another's [m]
    on_body: Array | None = None
    """[A] 1 for atoms that the whole body is held against, None where its position decides all."""


def to_device(problem: Problem) -> Problem:
    """All leaves as strongly typed JAX arrays, so that no call differs in weak types."""
    return jax.tree.map(lambda leaf: jnp.asarray(leaf, leaf.dtype), problem)


def atom_margins(robot: Robot, world: World, problem: Problem, state: Array) -> tuple[Array, Array]:
    """Margins of the atoms [A] in [m] in a state [n], and their gradients [A, d].

    Those of the robot's position. Atoms that are `on_body` are entered as soon as any ball of the
    body touches them: the largest, over position and balls, of margin plus radius.
    """
    margin, gradient = world.margins(problem.world, robot.position(state))
    if problem.on_body is None:
        return margin, gradient
    centers, radii = cast(BodiedRobot, robot).body(state)
    margins, gradients = jax.vmap(lambda center: world.margins(problem.world, center))(centers)
    margins = jnp.concatenate([margin[None], margins + radii[:, None]])
    gradients = jnp.concatenate([gradient[None], gradients])
    deepest = jnp.where(problem.on_body > 0, margins.argmax(0), 0)
    atom = jnp.arange(margin.shape[0])
    return margins[deepest, atom], gradients[deepest, atom]


def extended_margins(
    robot: Robot, world: World, problem: Problem, state: Array
) -> tuple[Array, Array]:
    """Margins of atoms and compound predicates: mu_ext [A + P] [m] and gradients [A + P, d].

    A compound predicate is max over its clauses of min over its signed atoms; its gradient is
    that of the atom which decides it.
    """
    margin, gradient = atom_margins(robot, world, problem, state)
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
        tau: present step.
    """
    closed = (start <= tau + 1) & (tau + 1 <= end)
    weight = problem.formula.door * closed
    bits = jnp.stack([(weight == 2**i).any() * 2**i for i in range(COMBINATIONS.bit_length() - 1)])
    return bits.sum().astype(jnp.int32)
