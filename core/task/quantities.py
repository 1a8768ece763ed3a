"""What predicates of the state may speak of: named quantities of a robot.

A robot names them with their units, as in `v [m/s]`, in `quantities`, and gives their values with
`named(state)`; of one that does not, they are the entries of its state. `x`, `y` and `z` are the
coordinates of its position, as many as that has.

Dimensions: Q quantities, n state, d position.
"""

from typing import NamedTuple, Protocol

import numpy as np

from core.task.protocols import Array, Robot

AXES = ("x", "y", "z")


class Quantity(NamedTuple):
    """A named quantity."""

    name: str
    unit: str
    """Empty for a pure number."""


class NamedRobot(Robot, Protocol):
    """A robot that names more, or other things, than the entries of its state."""

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names [Q] with units, as in `speed [m/s]`; each name is a word."""
        ...

    def named(self, state: Array) -> Array:
        """Values [Q] in a state [n]."""
        ...


def quantities_of(robot: Robot) -> tuple[Quantity, ...]:
    """The quantities that a robot names [Q]."""
    texts = getattr(robot, "quantities", None)
    if texts is None:
        texts = getattr(robot, "state_names", ())
    parts = (text.partition(" [") for text in texts)
    return tuple(Quantity(name.replace(" ", "_"), unit.rstrip("]")) for name, _, unit in parts)


def named_state(robot: Robot, state: Array) -> Array:
    """Values [Q] of the quantities in a state [n]."""
    own = getattr(robot, "named", None)
    return state if own is None else own(state)


def scales_of(robot: Robot) -> np.ndarray:
    """Metres [Q] that a unit of each quantity counts as: what is no length, a robot's length."""
    return np.array([1.0 if each.unit == "m" else robot.length for each in quantities_of(robot)])


def axes_of(robot: Robot) -> np.ndarray:
    """Derivatives [Q, d] of the quantities along the position, where they are its coordinates."""
    size = robot.position_size
    axes = np.zeros((len(quantities_of(robot)), size), np.float32)
    for row, each in enumerate(quantities_of(robot)):
        if each.name in AXES[:size]:
            axes[row, AXES.index(each.name)] = 1.0
    return axes
