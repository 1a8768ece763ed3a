"""What the trainer, the page and the bundles ask of a robot.

A robot is a frozen, hashable value: its constants are static under jit. All functions treat one
robot; `jax.vmap` batches them. Symbols: n size of the state, m of the action, d of the position.
"""

from typing import Protocol

import jax


class Robot(Protocol):
    """Discrete-time dynamics with named states and an action in [-1, 1]^m.

    Attributes:
        name: Key in `ENVS`.
        state_size: n.
        action_size: m.
        position_size: d, the dimension of the space in which regions live.
        dt: Duration of a step in [s].
        speed: Planning speed in [m/step]: what the robot can be trusted to cover on a path with
            turns and stops. Schedules faster than this are not sampled.
        workspace: (low, high) in [m] of each axis of the position; nothing clips to it.
        state_names: Names of the state's entries, with units.
        action_names: Names of the action's entries.
    """

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def state_size(self) -> int: ...  # noqa: D102
    @property
    def action_size(self) -> int: ...  # noqa: D102
    @property
    def position_size(self) -> int: ...  # noqa: D102
    @property
    def dt(self) -> float: ...  # noqa: D102
    @property
    def speed(self) -> float: ...  # noqa: D102
    @property
    def workspace(self) -> tuple[tuple[float, float], ...]: ...  # noqa: D102
    @property
    def state_names(self) -> tuple[str, ...]: ...  # noqa: D102
    @property
    def action_names(self) -> tuple[str, ...]: ...  # noqa: D102

    def rest(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """State [n] at the start of an episode: at rest at position [d], heading random."""
        ...

    def place(self, key: jax.Array, position: jax.Array) -> jax.Array:
        """State [n] in the middle of an episode at position [d]: heading and speed random."""
        ...

    def step(self, state: jax.Array, action: jax.Array) -> jax.Array:
        """Next state [n] after one step of dt; action [m] is clipped to [-1, 1]."""
        ...

    def position(self, state: jax.Array) -> jax.Array:
        """Position [..., d] in [m] of states [..., n]."""
        ...

    def observe(self, state: jax.Array) -> jax.Array:
        """The robot's own features, scaled to about 1 and free of position and heading."""
        ...

    def to_frame(self, state: jax.Array, vectors: jax.Array) -> jax.Array:
        """World vectors [..., d] in the frame of the robot in state [n]."""
        ...
