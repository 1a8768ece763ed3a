import pytest

from core.methods.tgpo.method import TgpoLearner
from studio.runs.tasks import initial_state


@pytest.fixture(scope="session")
def asked(linear_task, small_algorithm):
    """A task, an untrained controller and the state where the robot stands."""
    learner = TgpoLearner(linear_task, small_algorithm)
    controller = learner.controller(learner.fresh(0).parameters)
    return linear_task, controller, initial_state(linear_task)
