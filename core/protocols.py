"""What `core` asks of a robot and of the world it moves in.

Both are static: hashable objects without arrays, closed over by compiled programs. All numbers
that change with a scene or a formula live in pytrees that are passed as arguments, so that moving
a region or typing another formula compiles nothing.

Dimensions: n state, m action, d position (2 or 3), A atoms, k vector size in the robot's frame.
"""

from typing import Any, Protocol

import jax

Array = jax.Array


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
        """Distance that the robot is planned to travel in a step [m]."""
        ...

    @property
    def lag(self) -> float:
        """Steps that a leg may need on top of its distance, for turning and starting."""
        ...

    @property
    def length(self) -> float:
        """Length that features and rewards count as 1 [m]: a tenth of the workspace, say."""
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
        """Position [d] that the atoms speak about [m]."""
        ...

    def observe(self, state: Array) -> Array:
        """Scaled features of the state alone, independent of where the robot is."""
        ...

    def to_frame(self, state: Array, vectors: Array) -> Array:
        """World vectors [..., d] in the robot's frame [..., k]."""
        ...


class BodiedRobot(Robot, Protocol):
    """A robot that is more than a point: obstacles may be held against its whole body."""

    def body(self, state: Array) -> tuple[Array, Array]:
        """Centres [B, d] and radii [B] of balls that cover it [m]."""
        ...


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
