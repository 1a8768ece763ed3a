"""An entry of `METHODS` that carries out a formula as a whole."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, get_args

from core.controller import Controller
from core.errors import UserError
from core.methods.bounds import ModeName
from core.methods.method import Learner
from core.methods.whole_formula.controller import ATTEMPTS
from core.task.protocols import Robot
from core.task.task import Task


@dataclass(frozen=True)
class WholeFormulaMethod:
    """A baseline.

    Attributes:
        name: Identifier.
        title: What people choose it by.
        studio: Hyper-parameters of the studio mode.
        paper: The same type, of the paper mode.
        make_learner: From a task and hyper-parameters.
        make_controller: From hyper-parameters and weights.
    """

    name: str
    title: str
    studio: Any
    paper: Any
    make_learner: Callable[[Task, Any], Learner]
    make_controller: Callable[[Any, Any], Controller]

    @property
    def chooses_times(self) -> bool:
        """It knows no schedules."""
        return False

    @property
    def hyper_parameters(self) -> type:
        """The type of its presets."""
        return type(self.studio)

    def preset(self, mode: str, robot: Robot) -> Any:
        """Hyper-parameters in a mode, the same for every robot.

        Only evaluations during training differ: each initial state has ten attempts, so there are a
        tenth of the states, and evaluations take as long as TGPO's.
        """
        presets = {"studio": self.studio, "paper": self.paper}
        if mode not in presets:
            raise UserError(f"unknown mode {mode!r}. Available: {sorted(get_args(ModeName))}")
        states = max(1, robot.tuning.evaluation_states // ATTEMPTS)
        return replace(presets[mode], evaluation_states=states)

    def learner(self, task: Task, algorithm: Any, epoch: int = 1) -> Learner:
        """A learner; the first epoch makes no difference."""
        del epoch
        return self.make_learner(task, algorithm)

    def controller(self, algorithm: Any, weights: Any) -> Controller:
        """The controller of given weights."""
        return self.make_controller(algorithm, weights)
