"""Whom the page asks: a controller, and the task that it answers for."""

from typing import NamedTuple

import numpy as np

from core.controller import Controller
from core.task.task import Task


class Subject(NamedTuple):
    """What is queried: the weights after an epoch of training on a task."""

    training: object
    """Identity of the training (see `Training.identity`)."""
    task: Task
    controller: Controller
    epoch: int
    chains: np.ndarray | None = None
    """Schedules [C, V] that the search for times stands at."""
    weights: object = None
    """Of the controller; the same object while nothing new was learnt."""
    general: bool = False
    """Whether they are the robot's, which were trained on no scene."""
