"""A robot that is moved by somebody else: by a hand, a push, a gust of wind.

Dimensions: n state, d position.
"""

from typing import Any

import jax
import jax.numpy as jnp

from core.compilation import program
from core.task.protocols import Array, Robot

ITERATIONS = 12
"""Of Gauss-Newton; one is enough where the position is a part of the state."""

DAMPING = 1e-6


def moved(robot: Robot, state: Array, position: Array) -> Array:
    """The state [n] nearest to a state [n] whose position is the given one [d].

    What the position does not depend on stays: speed, heading, posture. A robot that needs more,
    such as one with joint limits, has a function `move(state, position)` of its own.
    """
    move: Any = getattr(robot, "move", None)
    if move is not None:
        return move(state, position)

    def nearer(state: Array, _: None) -> tuple[Array, None]:
        jacobian = jax.jacfwd(robot.position)(state)
        gram = jacobian @ jacobian.T + DAMPING * jnp.eye(jacobian.shape[0])
        gap = position - robot.position(state)
        return state + jacobian.T @ jnp.linalg.solve(gram, gap), None

    return jax.lax.scan(nearer, state, length=ITERATIONS)[0]


@program
def move_robot(state: Array, position: Array, *, robot: Robot) -> tuple[Array, Array]:
    """Compiled `moved`, and the position [d] that it has come to."""
    after = moved(robot, state, position)
    return after, robot.position(after)
