"""What a robot brings beyond what learning asks: what scenes and the page need."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from core.task.protocols import Robot as LearningRobot


@dataclass(frozen=True)
class Workspace:
    """Where a robot works, and how its ways are planned there.

    Attributes:
        arena: (low, high) in [m] of each axis of the position; nothing clips to it.
        spacing: Of the grid of the distance fields in [m]. About 80 nodes an axis in the plane
            and 20 to 35 in space serve well.
        clearance: Distance that planned ways keep from obstacles in [m].
        inset: Depth in goals that planned ways aim at in [m].
        reach: (low, high) in [m] of each axis that no scene's arena may leave, as an arm cannot;
            None for a robot that goes anywhere.
    """

    arena: tuple[tuple[float, float], ...]
    spacing: float
    clearance: float = 0.15
    inset: float = 0.1
    reach: tuple[tuple[float, float], ...] | None = None

    @property
    def middle(self) -> tuple[float, ...]:
        """Centre of the arena [d] in [m]."""
        return tuple((low + high) / 2 for low, high in self.arena)


class Robot(LearningRobot, Protocol):
    """Discrete-time dynamics with named states and an action in [-1, 1]^m.

    A robot is a frozen, hashable value: its constants are static under jit. All functions treat
    one robot; `jax.vmap` batches them. `envs.check.check_robot` says what a new one lacks.
    """

    @property
    def workspace(self) -> Workspace:
        """Where it works."""
        ...

    @property
    def state_names(self) -> tuple[str, ...]:
        """Names of the state's entries, with units."""
        ...

    @property
    def action_names(self) -> tuple[str, ...]:
        """Names of the action's entries."""
        ...

    @property
    def drawn_as(self) -> str:
        """Name of a body in `studio.page.views.bodies`; a plain ball where there is none."""
        ...

    @property
    def variants(self) -> Mapping[str, "Robot"]:
        """Other readings of it, by the names that scenes give them."""
        ...
