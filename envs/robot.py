"""What scenes, the page and the bundles ask of a robot beyond what learning asks."""

from typing import Protocol

from core.protocols import Robot as LearningRobot


class Robot(LearningRobot, Protocol):
    """Discrete-time dynamics with named states and an action in [-1, 1]^m.

    A robot is a frozen, hashable value: its constants are static under jit. All functions treat
    one robot; `jax.vmap` batches them.
    """

    @property
    def workspace(self) -> tuple[tuple[float, float], ...]:
        """(low, high) in [m] of each axis of the position; nothing clips to it."""
        ...

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the state's entries, with units."""
        ...

    @property
    def action_names(self) -> tuple[str, ...]:
        """Names of the action's entries."""
        ...
