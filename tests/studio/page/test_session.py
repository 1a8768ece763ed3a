import threading
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from core.errors import UserError
from core.methods.training import TrainingConfig
from scenes import load_task
from studio.page import analyst, trainer
from studio.page.planner import Planner
from studio.page.session import DEBOUNCE, Session
from studio.page.trainer import Phase
from tests.small import scripted_epoch
from tests.studio.waiting import ticked

LATE = 1e12
"""A monotonic time after every pause in typing [s]."""


@pytest.fixture
def session(monkeypatch, small_algorithm):
    """A session whose trainer ends after an epoch and whose analyst answers with markers."""
    monkeypatch.setattr(trainer, "train", lambda task, config, state=None: iter([scripted_epoch()]))
    monkeypatch.setattr(Planner, "_weights", lambda self, task: None)
    monkeypatch.setattr(analyst, "draw_picture", lambda *asked: cast(Any, asked))

    def answer(self, subject, request):
        recording = SimpleNamespace(
            task=subject.task,
            schedule=request.schedule,
            steps=5,
            weights=subject.controller.parameters,
            training=subject.training,
        )
        found = analyst.Answer(subject, cast(Any, (recording,)), asked=request.asked)
        self._publish(subject, request, **{"sample" if request.sample else "answer": found})

    monkeypatch.setattr(analyst.Analyst, "_answer", answer)

    def make_config(scene, limit):
        return TrainingConfig(small_algorithm, time_limit=limit)

    session = Session(load_task("linear-08"), None, make_config)
    yield session
    session.close()


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
    assert "Correct the formula" in session.error
    assert session.training.phase is Phase.IDLE


def test_training_takes_what_was_typed_last(session):
    session.post(lambda: session.edit("F_[0:90](A2)"))
    session.post(session.train)
    session.tick(0.0)
    assert session.error == ""
    assert len(session.training.task.grounding.decomposition.variables) == 1


def test_when_training_ends_the_critics_choice_plays(session):
    session.post(session.train)
    assert ticked(session, lambda: session.player.recording is not None)
    assert session.training.phase is Phase.DONE
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
    assert ticked(session, lambda: session.training.phase is Phase.DONE)
    assert not session.stale
    session.post(lambda: session.edit("F_[0:90](A2)"))
    session.tick(LATE)
    session.tick(LATE)
    assert session.stale
    assert session.training.weights == "best"


def test_another_task_drops_what_was_learnt(session):
    session.post(session.train)
    assert ticked(session, lambda: session.player.recording is not None)
    session.post(lambda: session.choose_task("linear-07"))
    session.tick(0.0)
    assert session.training.phase is Phase.IDLE
    assert session.player.recording is None
    assert session.analyst.picture is None


def test_a_second_training_waits_for_the_end_of_the_first(session, monkeypatch):
    gate = threading.Event()
    first = trainer.train

    def train(task, config, state=None):
        gate.wait(10)
        yield from first(task, config)

    monkeypatch.setattr(trainer, "train", train)
    session.post(session.train)
    session.tick(0.0)
    running = session.training.task
    session.post(lambda: session.edit("F_[0:90](A2)"))
    session.post(session.train)
    session.tick(0.0)
    assert session.queued is not None
    assert session.training.task is running
    gate.set()
    assert ticked(session, lambda: session.training.phase is Phase.DONE and not session.queued)
    assert ticked(session, lambda: session.training.task is not running)
    assert session.trained.formula == "F_[0:90](A2)"


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

    monkeypatch.setattr(trainer, "train", train)
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


def test_train_pressed_while_an_answer_is_on_its_way(session, monkeypatch):
    """Nothing of the old policy appears under the new training, which is shown at its end."""
    asked, answer = threading.Event(), threading.Event()
    give = analyst.Analyst._answer

    def slow(self, subject, request):
        asked.set()
        assert answer.wait(30)
        give(self, subject, request)

    session.post(session.train)
    assert ticked(session, lambda: session.player.recording is not None)
    old = session.training
    monkeypatch.setattr(analyst.Analyst, "_answer", slow)
    session.post(lambda: session.analyst.ask((1, 2, 3)))
    assert ticked(session, asked.is_set)
    session.post(session.train)
    assert ticked(session, lambda: session.training.identity is not old.identity)
    assert ticked(session, lambda: session.training.phase is Phase.DONE)
    assert not session.player.recording
    answer.set()
    assert ticked(session, lambda: session.player.recording)
    shown = session.player.recording
    assert (shown.training, shown.schedule) == (session.training.identity, None)
    assert not session.gallery.ghosts


def test_what_was_asked_of_another_training_is_dropped_at_receipt(session):
    session.post(session.train)
    assert ticked(session, lambda: session.player.recording is not None)
    session.post(session.analyst.ask_sample)
    assert ticked(session, lambda: bool(session.gallery.sample))
    playing = session.player.recording
    sample, ghosts = session.gallery.sample, session.gallery.ghosts
    own = session.analyst.answer.subject
    late = analyst.Answer(own._replace(training=object()), cast(Any, ("late",)))
    session.analyst.answer = session.analyst.sample = late
    session.tick(0.0)
    assert session.player.recording is playing
    assert (session.gallery.sample, session.gallery.ghosts) == (sample, ghosts)


def test_a_policy_is_of_one_training_while_another_takes_its_place(session, monkeypatch):
    """Exports run on threads of their own, beside the loop that starts trainings."""
    session.post(session.train)
    assert ticked(session, lambda: session.training.phase is Phase.DONE)
    one = session.training
    edited = replace(one.scene, formula="F_[0:90](A2)", seed=5)
    config = replace(one.config, method="tgpo", seed=5)
    other = trainer.Training(Phase.TRAINING, one.task, config, edited, epoch=9, weights="other")
    snapshots = iter([one, *[other] * 20])
    monkeypatch.setattr(Session, "training", property(lambda self: next(snapshots)))
    policy = session.policy()
    assert (policy.scene, policy.weights, policy.epochs) == (one.scene, "best", one.epoch)
    assert (policy.method, policy.seed, policy.success_rate) == ("tgpo-star", one.config.seed, 1.0)
