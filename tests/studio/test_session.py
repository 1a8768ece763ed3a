import threading
from types import SimpleNamespace
from typing import Any, cast

import pytest

from core.errors import UserError
from core.training import TrainingConfig
from scenes import load_task
from studio import analyst, worker
from studio.session import DEBOUNCE, Session
from studio.worker import Stage
from tests.studio.waiting import wait_for

LATE = 1e12
"""A monotonic time after every pause in typing [s]."""


@pytest.fixture
def session(monkeypatch):
    """A session whose trainer ends after an epoch and whose analyst answers with markers."""
    learner = SimpleNamespace(chains=None)
    state = SimpleNamespace(best="best", best_success=1.0, learner=learner)
    epoch = SimpleNamespace(
        epoch=1,
        env_steps=10,
        train_seconds=0.1,
        batch_success=0.5,
        batch_return=0.0,
        diverged=0,
        evaluation=SimpleNamespace(success_rate=1.0),
        parameters="weights",
        state=state,
    )
    monkeypatch.setattr(worker, "train", lambda task, config, state=None: iter([epoch]))
    monkeypatch.setattr(analyst, "_draw", lambda *asked: cast(Any, asked))

    def answer(self, subject, request):
        self.recording = SimpleNamespace(
            task=subject.task, schedule=request.schedule, steps=5, weights=subject.parameters
        )
        self._request = None

    monkeypatch.setattr(analyst.Analyst, "_answer", answer)
    session = Session(
        load_task("linear-08"), None, lambda scene, limit: TrainingConfig(time_limit=limit)
    )
    yield session
    session.close()


def ticked(session, condition):
    def check():
        session.tick(0.0)
        return condition()

    return wait_for(check)


def test_a_formula_is_judged_when_the_typing_pauses(session):
    import time

    session.post(lambda: session.edit("F_[0:90](A7)"))
    session.tick(time.monotonic())
    assert session.specification.error == ""
    session.tick(time.monotonic() + DEBOUNCE + 0.01)
    assert "A7" in session.specification.error


def test_changes_are_made_by_the_tick(session):
    session.post(lambda: session.choose_task("unicycle-01"))
    assert session.specification.scene.name == "linear-08"
    session.tick(0.0)
    assert session.specification.scene.name == "unicycle-01"


@pytest.mark.parametrize("error", [UserError("say so"), ZeroDivisionError("oh")])
def test_an_error_in_a_change_is_shown_and_the_page_lives_on(session, error, capsys):
    def fail():
        raise error

    session.post(fail)
    session.tick(0.0)
    assert str(error) in session.error
    session.post(lambda: None)
    session.tick(0.0)
    assert session.error == ""


def test_training_needs_a_right_formula(session):
    session.post(lambda: session.edit("F_[0:90](A7)"))
    session.post(session.train)
    session.tick(0.0)
    assert "formula without errors" in session.error
    assert session.training.stage is Stage.IDLE


def test_training_takes_what_was_typed_last(session):
    session.post(lambda: session.edit("F_[0:90](A2)"))
    session.post(session.train)
    session.tick(0.0)
    assert session.error == ""
    assert len(session.training.task.grounding.decomposition.variables) == 1


def test_when_training_ends_the_critics_choice_plays(session):
    session.post(session.train)
    assert ticked(session, lambda: session.player.recording is not None)
    assert session.training.stage is Stage.DONE
    assert session.player.recording.schedule is None
    assert session.player.recording.weights == "best"
    assert session.player.playing


def test_a_click_plays_its_schedule(session):
    session.post(session.train)
    assert ticked(session, lambda: session.player.recording is not None)
    session.post(lambda: session.analyst.ask((1, 2, 3)))
    assert ticked(session, lambda: session.player.recording.schedule == (1, 2, 3))


def test_an_edit_makes_what_was_learnt_stale(session):
    session.post(session.train)
    assert ticked(session, lambda: session.training.stage is Stage.DONE)
    assert not session.stale
    session.post(lambda: session.edit("F_[0:90](A2)"))
    session.tick(LATE)
    session.tick(LATE)
    assert session.stale
    assert session.training.parameters == "best"


def test_another_task_drops_what_was_learnt(session):
    session.post(session.train)
    assert ticked(session, lambda: session.player.recording is not None)
    session.post(lambda: session.choose_task("linear-07"))
    session.tick(0.0)
    assert session.training.stage is Stage.IDLE
    assert session.player.recording is None
    assert session.analyst.picture is None


def test_a_second_training_waits_for_the_end_of_the_first(session, monkeypatch):
    gate = threading.Event()
    first = worker.train

    def train(task, config, state=None):
        gate.wait(10)
        yield from first(task, config)

    monkeypatch.setattr(worker, "train", train)
    session.post(session.train)
    session.tick(0.0)
    running = session.training.task
    session.post(lambda: session.edit("F_[0:90](A2)"))
    session.post(session.train)
    session.tick(0.0)
    assert session.queued is not None
    assert session.training.task is running
    gate.set()
    assert ticked(session, lambda: session.training.stage is Stage.DONE and not session.queued)
    assert ticked(session, lambda: session.training.task is not running)
    assert session.trained.formula == "F_[0:90](A2)"


def test_a_shipped_policy_plays_without_training(session):
    session.post(session.show_shipped)
    assert ticked(session, lambda: session.player.recording is not None)
    assert session.training.stage is Stage.LOADED
    assert session.policy().success_rate >= 0.97
    assert not session.stale


def test_there_is_no_policy_before_training(session):
    with pytest.raises(UserError, match="no policy yet"):
        session.policy()


def test_another_task_waits_for_a_word_on_unsaved_edits(session):
    session.edit("F_[0:90](A2)")
    session.leave(lambda: session.choose_task("linear-07"))
    assert session.leaving is not None
    session.confirm(False)
    assert session.document.scene.name == "linear-08"
    session.tick(float("inf"))
    assert session.unsaved
    session.document.mark_saved()
    session.leave(lambda: session.choose_task("linear-07"))
    assert session.document.scene.name == "linear-07"


def test_another_task_waits_for_a_word_while_training_runs(session, monkeypatch):
    going_on = threading.Event()

    def train(task, config, state=None):
        going_on.wait(30)
        yield from ()

    monkeypatch.setattr(worker, "train", train)
    session.post(session.train)
    assert ticked(session, lambda: session.training.busy)

    def ask():
        session.post(lambda: session.leave(lambda: session.choose_task("linear-07")))
        session.tick(0.0)

    ask()
    assert session.leaving is not None
    assert (session.document.scene.name, session.training.busy) == ("linear-08", True)
    session.confirm(False)
    assert session.leaving is None
    assert (session.document.scene.name, session.training.busy) == ("linear-08", True)
    ask()
    session.confirm(True)
    going_on.set()
    assert session.document.scene.name == "linear-07"
    assert session.leaving is None
