"""The neutral interface: what every method hands over, and all that others know of a method.

    score(x0, t) -> value     how promising schedule t is from the initial state x0
    start(x0, t) -> s         the controller's memory before its first step
    step(s, x)   -> (s', u)   action u in [-1, 1]^m for the measured state x; the first x is x0

Evaluation, rollouts, the map, the page, bundles and exports use controllers and nothing else.

Dimensions: n state, m action, V variables (padded).
"""

from collections.abc import Sequence
from typing import Any, Protocol, Self

import jax.numpy as jnp

from core.task.problem import Problem
from core.task.protocols import Array
from core.task.schedules import Search

NO_SCHEDULES = "This method does not choose times: it carries out the formula as a whole."
"""Why there is no map of a controller whose `search` is None."""


class Controller(Protocol):
    """A pytree: weights are data, everything else is static and hashable.

    All functions treat one episode and can be traced by JAX.
    """

    @property
    def search(self) -> Search | None:
        """How the schedules that it chooses from are drawn; None if it knows no schedules (V = 0).

        Such a controller is given schedules all the same, and ignores them.
        """
        ...

    @property
    def attempts(self) -> Sequence[Self]:
        """Controllers of which the best trace counts in an evaluation, itself first.

        They differ in data alone. Itself only, where one attempt has to do.
        """
        ...

    def score(self, problem: Problem, state: Array, schedule: Array) -> Array:
        """How promising a schedule [V] is from an initial state [n]; comparable within a task."""
        ...

    def start(self, problem: Problem, state: Array, schedule: Array) -> Any:
        """Memory (a pytree) before the first step of a schedule [V] from a state [n]."""
        ...

    def step(self, problem: Problem, memory: Any, state: Array) -> tuple[Any, Array]:
        """The next memory, and the action [m] for a measured state [n]."""
        ...


def pad_schedule(problem: Problem, schedule: Array) -> Array:
    """A schedule of the formula's own variables, padded to [V]."""
    return jnp.zeros(problem.formula.low.shape, jnp.int32).at[: schedule.shape[0]].set(schedule)
