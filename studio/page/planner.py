"""Answers before training: the robot's weights, at work on whatever scene was judged last."""

from typing import Any

from core.methods.training import RunState, TrainingConfig, state_from_weights
from core.task.task import Task
from studio.page.editing.specification import Specification
from studio.page.trainer import Phase, Training
from studio.runs.pretrained import Pretrained, fitting, shipped_weights

ORIGIN = "the robot's weights"


class Planner:
    """Read `training` after `observe`."""

    def __init__(self) -> None:
        self.training: Training | None = None
        """The weights on the judged scene, as if they were loaded; None where there are none."""
        self._task: Task | None = None
        self._known: dict[str, Pretrained | None] = {}

    def observe(self, specification: Specification) -> None:
        """Take over a judged scene; one with an error keeps the last."""
        task = specification.task
        if task is None or specification.error or task is self._task:
            return
        self._task = task
        found = self._weights(task)
        if found is None:
            self.training = None
            return
        config = TrainingConfig(found.algorithm, found.card.method, seed=found.card.seed)
        self.training = Training(
            Phase.LOADED,
            task,
            config,
            specification.scene,
            epoch=found.card.epochs,
            weights=found.weights,
            origin=ORIGIN,
            general=True,
        )

    def first_state(self, task: Task, config: TrainingConfig) -> RunState | None:
        """State of a training that begins with the weights; None where it cannot.

        Paper mode and networks of another shape begin from scratch.
        """
        found = self._weights(task)
        if found is None or not fitting(found.card, config.algorithm):
            return None
        return state_from_weights(task, config, found.weights)

    def _weights(self, task: Task) -> Any:
        name = task.robot.name
        if name not in self._known:
            self._known[name] = shipped_weights(task)
        return self._known[name]
