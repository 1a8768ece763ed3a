"""What `core` requires of a robot and of the world it moves in.

Both are static: hashable objects without arrays, closed over by compiled programs. All numbers
that change with a scene or a formula live in pytrees that are passed as arguments, so that moving
a region or typing another formula needs no compilation.

Dimensions: n state, m action, d position (2 or 3), A atoms, k vector size in the robot's frame.
"""

import math
from dataclasses import dataclass
from typing import Any, Protocol

import jax

Array = jax.Array


@dataclass(frozen=True)
class Tuning:
    """What a robot wants to be trained with; the defaults serve one that stops at once.

    Attributes:
        violation: Reward of a violated constraint, lambda_4 of the paper's Table A.1.
        gradual_stays: Whether a stay is paid step by step: for robots that cannot stop at once.
        learning_rate: Of Adam.
        epochs: Most epochs of a training by default.
        model_epochs: Epochs that learn from `step` before true physics takes over, where the
            robot has both (see `core.task.physics`).
        evaluation_states: Initial states of an evaluation while training.

    Paper mode takes `violation` alone: its other numbers are the paper's for every robot.
    """

    violation: float = -3.0
    gradual_stays: bool = False
    learning_rate: float = 2e-3
    epochs: int = 200
    model_epochs: int = 10**6
    evaluation_states: int = 512


class Robot(Protocol):
    """A discrete-time system x' = f(x, u), one state at a time (batches by `vmap`)."""

    @property
    def name(self) -> str:
        """Identifier, as in scene files."""
        ...

    @property
    def state_size(self) -> int:
        """n."""
        ...

    @property
    def action_size(self) -> int:
        """m."""
        ...

    @property
    def position_size(self) -> int:
        """d."""
        ...

    @property
    def dt(self) -> float:
        """Duration of a step [s]."""
        ...

    @property
    def speed(self) -> float:
        """Distance per step at which legs are planned [m]."""
        ...

    @property
    def lag(self) -> float:
        """Extra steps that a leg may need for turning and starting."""
        ...

    @property
    def length(self) -> float:
        """Unit of length in features and rewards [m], about a tenth of the workspace."""
        ...

    @property
    def tuning(self) -> Tuning:
        """What it wants to be trained with."""
        ...

    def rest(self, key: Array, position: Array) -> Array:
        """State [n] at rest at a position [d]: the start of an episode."""
        ...

    def place(self, key: Array, position: Array) -> Array:
        """State [n] in motion at a position [d]: an exploring start."""
        ...

    def step(self, state: Array, action: Array) -> Array:
        """Next state [n]; actions [m] are normalised and clipped to [-1, 1]."""
        ...

    def position(self, state: Array) -> Array:
        """Position [d] to which the atoms refer [m]."""
        ...

    def observe(self, state: Array) -> Array:
        """Scaled features of the state alone, independent of where the robot is."""
        ...

    def to_frame(self, state: Array, vectors: Array) -> Array:
        """World vectors [..., d] in the robot's frame [..., k]."""
        ...


class BodiedRobot(Robot, Protocol):
    """A robot that is more than a point."""

    @property
    def links(self) -> bool:
        """Whether obstacles are held against its whole body."""
        ...

    def body(self, state: Array) -> tuple[Array, Array]:
        """Centres [B, d] and radii [B] of balls that cover it [m]."""
        ...


def has_body(robot: Robot) -> bool:
    """Whether obstacles are held against more of a robot than its position."""
    return bool(getattr(robot, "links", False))


class BoundedRobot(Robot, Protocol):
    """A robot of which it is proved how fast it can be at most, and where it begins."""

    @property
    def begins_exactly(self) -> bool:
        """Whether `rest` puts it exactly where it is asked for."""
        ...

    def farthest(self, step: int) -> tuple[float, ...]:
        """What no step number `step` of any episode exceeds, from 0 on; never less later on.

        The changes [d + 1] of each coordinate and the length of the change of position [m].
        """
        ...


def begins_exactly(robot: Robot) -> bool:
    """Whether it is proved that `rest` puts a robot exactly where it is asked for."""
    return bool(getattr(robot, "begins_exactly", False))


def farthest_of(robot: Robot, step: int) -> tuple[float, ...]:
    """`BoundedRobot.farthest`; infinite where nothing is proved."""
    bound = getattr(robot, "farthest", None)
    return (math.inf,) * (robot.position_size + 1) if bound is None else bound(step)


class IntegratorRobot(Robot, Protocol):
    """A robot whose state is its position, moved by its action: x' = x + stride * clip(u)."""

    @property
    def stride(self) -> tuple[float, ...]:
        """Most that a coordinate changes in a step [d] [m]."""
        ...


def stride_of(robot: Robot) -> tuple[float, ...] | None:
    """`IntegratorRobot.stride`; None for a robot that moves otherwise."""
    return getattr(robot, "stride", None)


class World(Protocol):
    """Geometry behind the atoms. `data` is the pytree that the world made for a scene."""

    def margins(self, data: Any, position: Array) -> tuple[Array, Array]:
        """Margin of every atom [A] in metres and its gradient [A, d] at a position [d]."""
        ...

    def field(self, data: Any, index: Array, position: Array) -> tuple[Array, Array]:
        """Geodesic distance [m] and unit direction [d] of travel in the index-th field."""
        ...

    def sample_initial(self, data: Any, key: Array) -> Array:
        """A position [d] of the initial set."""
        ...


class MovingWorld(World, Protocol):
    """A world whose regions move along paths that are known beforehand."""

    def at(self, data: Any, step: Array) -> Any:
        """The data at a step, or between two: margins and fields are those of that time."""
        ...

    def displacements(self, data: Any) -> Array:
        """How far regions have moved [U, d] by then, each different way once, and 0 [m]."""
        ...
