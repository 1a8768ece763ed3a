"""What a method is: it learns epoch by epoch, and hands over controllers."""

from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np

from core.controller import Controller
from core.task.protocols import Robot
from core.task.task import Task


class Epoch(NamedTuple):
    """What a learner reports of an epoch."""

    success: float
    """Share of the epoch's first episodes (as they were explored) that succeeded."""
    mean_reward: float
    """Per step."""
    diverged: int
    """Simulations that broke down; their episodes count as failed."""
    schedules: np.ndarray | None = None
    """Schedules [C, V] that the search for times stands at, if there is one."""


class Learner(Protocol):
    """A method at work on one task. Its state is a pytree of arrays, opaque to everybody else."""

    @property
    def steps_per_epoch(self) -> int:
        """Steps of the environment that an epoch takes."""
        ...

    @property
    def evaluation_states(self) -> int:
        """Initial states of an evaluation while training."""
        ...

    @property
    def pace_change(self) -> int | None:
        """Epoch after which epochs take longer, None if they do not."""
        ...

    def fresh(self, seed: int) -> Any:
        """State before the first epoch; nothing is compiled."""
        ...

    def jobs(self, state: Any) -> list[Callable[[], Any]]:
        """Compilations that epochs need, to be run side by side.

        Raises:
            UserError: an epoch takes more memory than is free.
        """
        ...

    def epoch(self, state: Any, number: int) -> tuple[Any, Epoch]:
        """Learn for the epoch of a number, from 1; deterministic in state and number."""
        ...

    def weight_shapes(self) -> Any:
        """Stands for the weights of any state; nothing of their size is made."""
        ...

    def weights(self, state: Any) -> Any:
        """What a controller keeps of a state: a pytree of arrays."""
        ...

    def with_weights(self, state: Any, weights: Any) -> Any:
        """The state, learning on from given weights; it explores as at the start."""
        ...

    def controller(self, weights: Any) -> Controller:
        """The controller of given weights."""
        ...


class Method(Protocol):
    """An entry of `METHODS`."""

    @property
    def name(self) -> str:
        """Identifier, as in files, on the command line and on the page."""
        ...

    @property
    def title(self) -> str:
        """What people choose it by."""
        ...

    @property
    def chooses_times(self) -> bool:
        """Whether its controllers know schedules (`Controller.search`); one way for all of them.

        Only then can weights serve every task of a robot, and layouts vary.
        """
        ...

    @property
    def hyper_parameters(self) -> type:
        """The frozen dataclass of its presets; it has `mode_name` and `check`."""
        ...

    def preset(self, mode: str, robot: Robot) -> Any:
        """Hyper-parameters, a frozen dataclass, in a mode for a robot.

        Raises:
            UserError: unknown mode.
        """
        ...

    def learner(self, task: Task, algorithm: Any, epoch: int = 1) -> Learner:
        """A learner with these hyper-parameters; `epoch` is the first that it will be asked for."""
        ...

    def controller(self, algorithm: Any, weights: Any) -> Controller:
        """The controller of given weights, for any task of the robot that it was trained for."""
        ...
