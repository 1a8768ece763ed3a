"""What happens while an answer is on its way: another training, another click."""

import threading

import pytest

import studio.page.asking as module
from core.errors import UserError
from core.methods import METHODS
from core.methods.training import TrainingConfig
from studio.page.analyst import Analyst
from studio.page.trainer import Phase, Training
from tests.studio.waiting import Gate, wait_for

FIRST, SECOND = (20, 50, 15), (80, 45, 10)


@pytest.fixture
def trainings(linear_task, small_algorithm):
    """Two trainings with the same weights on the same task."""
    learner = METHODS["tgpo-star"].learner(linear_task, small_algorithm)
    weights, config = learner.weights(learner.fresh(seed=0)), TrainingConfig(small_algorithm)
    return [Training(Phase.TRAINING, linear_task, config, weights=weights) for _ in range(2)]


roll_out = module.roll_out


def shown(analyst):
    """Schedules of the rollouts that were answered with."""
    answer = analyst.answer
    return [] if answer is None else [recording.schedule for recording in answer.recordings]


@pytest.mark.parametrize("ask", [lambda analyst: analyst.ask(FIRST), Analyst.ask_sample])
def test_an_answer_of_the_old_training_is_dropped(trainings, monkeypatch, ask):
    old, new = trainings
    gate, analyst = Gate(roll_out), Analyst()
    monkeypatch.setattr(module, "roll_out", gate)
    analyst.watched = False
    analyst.observe(old)
    ask(analyst)
    assert gate.entered.acquire(timeout=120), analyst.error
    analyst.forget()
    analyst.observe(new)
    analyst.ask(SECOND)
    gate.open.release()
    assert gate.entered.acquire(timeout=120)  # the old answer has been given by now
    assert (shown(analyst), analyst.sample, analyst.busy) == ([], None, True)
    gate.open.release()
    assert wait_for(lambda: shown(analyst) == [SECOND]), analyst.error
    assert analyst.answer is not None and analyst.answer.subject.training is new.identity
    assert analyst.close()


class Clicking(Analyst):
    """An analyst at which somebody clicks in the moment after it has looked for a new request."""

    armed = False

    @property
    def _request(self):
        found = self._kept
        if self.armed and threading.current_thread().name == "analyst":
            self.armed = False
            click = threading.Thread(target=self.ask, args=(SECOND,))
            click.start()
            click.join(0.3)  # time enough to come in between, were it not kept out
        return found

    @_request.setter
    def _request(self, request):
        self._kept = request


def test_a_click_while_an_answer_is_given_is_answered(trainings, monkeypatch):
    analyst = Clicking()

    def rolled_out(*asked):
        analyst.armed = len(answered) == 0
        answered.append(asked)
        return roll_out(*asked)

    answered = []
    monkeypatch.setattr(module, "roll_out", rolled_out)
    analyst.watched = False
    analyst.observe(trainings[0])
    analyst.ask(FIRST)
    assert wait_for(lambda: len(answered) == 2), analyst.error
    assert wait_for(lambda: shown(analyst) == [SECOND]), analyst.error
    assert not analyst.busy
    assert analyst.close()


def test_a_search_that_an_edit_waits_for_ends_with_what_it_has(trainings, monkeypatch):
    interrupted: list[bool] = []

    def answer(task, controller, state, *, effort):
        while not (interrupted and interrupted[-1]):
            interrupted.append(effort.interrupted())
            analyst.hurried = len(interrupted) == 3
        raise UserError("enough")

    monkeypatch.setattr(module, "answer", answer)
    analyst = Analyst()
    analyst.watched = False
    analyst.observe(trainings[0])
    analyst.ask()
    assert wait_for(lambda: bool(analyst.error)), interrupted
    assert interrupted == [False, False, False, True]
    assert analyst.close()
