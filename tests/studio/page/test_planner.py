"""The page answers edits by the robot's weights, with no button pressed."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest
from msgspec import to_builtins

from core.methods import METHODS
from core.methods.training import TrainingConfig
from scenes import load_task
from studio.page import analyst, trainer
from studio.page.panels.plan import plan_html
from studio.page.planner import Planner
from studio.page.session import Session
from studio.page.trainer import Phase
from studio.runs.json_documents import algorithm_document
from studio.runs.pretrained import Pretrained
from tests.small import scripted_epoch
from tests.studio.waiting import ticked


@pytest.fixture
def session(monkeypatch, small_algorithm, linear_task):
    """A session with untrained weights of the robot, whose analyst answers with markers."""
    learner = METHODS["tgpo"].learner(linear_task, small_algorithm)
    algorithm = to_builtins(algorithm_document(small_algorithm))
    card = SimpleNamespace(
        seed=3, epochs=7, method="tgpo", mode="studio", robot="linear", algorithm=algorithm
    )
    weights = Pretrained(small_algorithm, learner.weights(learner.fresh(0)), cast(Any, card))
    monkeypatch.setattr(Planner, "_weights", lambda self, task: weights)
    monkeypatch.setattr(trainer, "train", lambda task, config, state=None: iter([scripted_epoch()]))
    monkeypatch.setattr(analyst, "draw_picture", lambda *asked: cast(Any, asked))

    def answer(self, subject, request):
        recording = SimpleNamespace(task=subject.task, schedule=request.schedule, steps=5)
        found = analyst.Answer(subject, cast(Any, (recording,)), asked=request.asked)
        self._publish(subject, request, answer=found)

    monkeypatch.setattr(analyst.Analyst, "_answer", answer)
    session = Session(
        load_task("linear-08"),
        None,
        lambda scene, limit: TrainingConfig(small_algorithm, time_limit=limit),
    )
    yield session
    session.close()


def playing(session):
    """The task of the plan on screen."""
    recording = session.player.recording
    return None if recording is None else recording.task


def test_a_plan_plays_without_any_button(session):
    assert ticked(session, lambda: session.player.recording is not None)
    assert session.training.phase is Phase.IDLE
    assert session.subject.origin == "the robot's weights"
    assert not session.gallery.ghosts


def test_an_edit_is_answered_by_a_plan_for_what_is_shown(session):
    assert ticked(session, lambda: session.player.recording is not None)
    first = session.player.recording.task
    session.post(lambda: session.document.set_formula("F_[0:90](A2)"))
    assert ticked(session, lambda: playing(session) not in (None, first))
    assert session.player.recording.task is session.specification.task
    assert session.error == session.analyst.stale == ""


def test_a_wrong_formula_keeps_the_last_plan(session):
    assert ticked(session, lambda: session.player.recording is not None)
    first = session.player.recording
    session.post(lambda: session.document.set_formula("F_[0:90](A7)"))
    session.tick(0.0)
    assert "A7" in session.specification.error
    assert session.player.recording is first


def test_a_region_that_is_dragged_is_followed_before_it_is_let_go(session):
    assert ticked(session, lambda: session.player.recording is not None)
    first = session.player.recording.task
    center = session.document.scene.regions[0].center
    name = session.document.scene.region_names[0]
    session.editor._grab = cast(Any, object())
    session.post(lambda: session.document.move(name, [c + 0.1 for c in center], "drag"))
    assert ticked(session, lambda: playing(session) not in (None, first))
    assert session.editor.dragging


@pytest.mark.parametrize(
    ("nudged", "text"),
    [
        (False, "Planned without training in 0.50 s; 3 of 64 starts succeed."),
        (
            True,
            "Planned without training in 0.50 s, nudged for this start; "
            "without nudges 3 of 64 starts succeed.",
        ),
    ],
)
def test_the_page_says_whether_a_plan_was_nudged(session, nudged, text):
    assert ticked(session, lambda: session.player.recording is not None)
    subject = session.analyst.answer.subject
    recording = SimpleNamespace(satisfied=True, nudged=nudged)
    session.analyst.answer = analyst.Answer(subject, cast(Any, (recording,)), seconds=0.5)
    session.analyst.share = analyst.Share(subject, 3, 64)
    assert text in plan_html(session)


def test_what_was_trained_answers_until_the_scene_is_edited(session):
    assert ticked(session, lambda: session.player.recording is not None)
    session.post(session.train)
    assert ticked(session, lambda: session.training.phase is Phase.DONE)
    session.tick(0.0)
    assert session.subject is session.training
    session.post(lambda: session.document.set_formula("F_[0:90](A2)"))
    assert ticked(session, lambda: session.subject is session.planner.training)
    assert session.stale and session.analyst.stale == ""
    assert ticked(session, lambda: playing(session) is session.specification.task)


def test_training_begins_with_the_weights_unless_told_otherwise(session, monkeypatch):
    begun = []

    def train(task, config, state=None):
        begun.append((config.warm, state is not None))
        yield scripted_epoch()

    monkeypatch.setattr(trainer, "train", train)
    session.post(session.train)
    assert ticked(session, lambda: len(begun) == 1 and not session.training.busy)
    session.settings.from_weights = False
    session.post(session.train)
    assert ticked(session, lambda: len(begun) == 2)
    assert begun == [(True, True), (False, False)]


def test_networks_of_another_shape_begin_from_scratch(session, small_algorithm, linear_task):
    other = TrainingConfig(replace(small_algorithm, hidden=(8,)))
    assert session.planner.first_state(linear_task, other) is None
    assert session.planner.first_state(linear_task, TrainingConfig(small_algorithm)) is not None
