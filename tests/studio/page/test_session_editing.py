"""Sessions whose scene is edited: undo, redo and typing, one history."""

import time

import pytest

from core.errors import UserError
from core.methods.training import TrainingConfig
from scenes import load_task
from studio.page.analyst import Analyst
from studio.page.editing.meaning import stale_text
from studio.page.session import DEBOUNCE, Session
from tests.studio.waiting import wait_for


@pytest.fixture
def session(small_algorithm):
    config = TrainingConfig(small_algorithm)
    session = Session(load_task("linear-08"), None, lambda *_, **__: config)
    yield session
    session.close()


def later():
    return time.monotonic() + DEBOUNCE + 0.01


def ticked(session):
    session.tick(later())
    return session.specification


def test_typing_is_a_step_of_the_history(session):
    session.edit("F_[0:90](A2)")
    session.tick(later())
    assert session.specification.text == "F_[0:90](A2)"
    session.undo()
    session.tick(later())
    assert session.specification.text == load_task("linear-08").formula
    assert session.text == load_task("linear-08").formula
    session.redo()
    session.tick(later())
    assert session.text == "F_[0:90](A2)"


def test_undo_takes_back_what_was_typed_just_now(session):
    session.edit("F_[0:90](A2)")
    session.undo()
    session.tick(later())
    assert session.text == load_task("linear-08").formula


def test_a_formula_that_no_scene_can_have_stays_in_the_editor(session):
    session.edit("")
    session.tick(later())
    assert session.text == ""
    assert "non-empty text" in session.specification.error
    session.edit("F_[0:90](A2)")
    session.tick(later())
    assert (session.text, session.specification.error) == ("F_[0:90](A2)", "")


def test_a_rename_brings_a_task_with_the_new_name(session):
    before = session.specification.task
    session.document.rename("A2", "Home")
    assert wait_for(lambda: ticked(session).task is not before)
    names = session.specification.task.grounding.decomposition.formula
    assert "Home" in str(names)
    assert "Home" in session.text


def test_while_a_region_is_dragged_nothing_is_judged(session):
    task = session.specification.task
    session.editor.move("A1", "start", (0.0, 0.0), (0.0, 0.0))
    session.editor.move("A1", "update", (0.0, 0.0), (1.0, 0.0))
    session.tick(later())
    assert session.specification.task is task
    session.editor.move("A1", "end", (0.0, 0.0), (1.0, 0.0))
    assert wait_for(lambda: ticked(session).task is not task)


def test_an_edit_that_waits_for_an_answer_hurries_it(session, monkeypatch):
    assert wait_for(lambda: ticked(session).task is not None)
    monkeypatch.setattr(Analyst, "busy", True)
    session.editor.move("A1", "start", (0.0, 0.0), (0.0, 0.0))
    session.tick(later())
    assert not session.analyst.hurried
    session.editor.move("A1", "update", (0.0, 0.0), (1.0, 0.0))
    session.tick(later())
    assert session.analyst.hurried
    monkeypatch.setattr(Analyst, "busy", False)
    assert wait_for(lambda: ticked(session) and not session.analyst.hurried)


def test_undo_during_a_drag_takes_only_the_drag_back(session):
    session.document.rename("A2", "Home")
    session.editor.move("A1", "start", (0.0, 0.0), (0.0, 0.0))
    session.editor.move("A1", "update", (0.0, 0.0), (1.0, 0.0))
    session.undo()
    assert session.document.region("A1").center == (-3.0, 2.8)
    assert "Home" in session.document.scene.region_names


def test_stale_weights_answer_no_question(session):
    session.analyst.stale = stale_text(("region A1",))
    with pytest.raises(UserError, match="region A1 has changed"):
        session.analyst.ask((1, 2, 3))


@pytest.mark.parametrize(
    ("reasons", "text"),
    [
        ((), ""),
        (("the formula",), "the formula has changed"),
        (("the regions",), "the regions have changed"),
        (("region A", "region B", "the horizon"), "region A, region B and the horizon have"),
    ],
)
def test_the_reasons_make_a_sentence(reasons, text):
    assert text in stale_text(reasons)
    assert bool(reasons) == bool(stale_text(reasons))
