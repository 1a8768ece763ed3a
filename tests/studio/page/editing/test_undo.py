"""Undo and redo: what is a step, and what is unsaved."""

import pytest

from core.errors import UserError
from core.stl import parse
from studio.page.editing.history import CAPACITY, History
from tests.studio.page.editing.draft import DT, scene


def test_deleting_a_region_that_the_formula_names_is_undone_with_it(document):
    document.delete("A1")
    assert document.scene.formula == scene().formula
    with pytest.raises(UserError, match="unknown name 'A1'"):
        parse(document.scene.formula, dt=DT, names=document.scene.region_names)
    document.undo()
    assert document.scene == scene()


def test_a_drag_is_one_step(document):
    for x in range(5):
        document.move("C", (x, 0), gesture="7")
    document.move("B", (1, 0), gesture="7")
    document.move("C", (9, 9), gesture="8")
    assert [document.undo(), document.undo(), document.undo(), document.undo()] == [
        "move C",
        "move B",
        "move C",
        None,
    ]
    assert document.scene == scene()
    assert document.redo() == "move C"
    assert document.region("C").center == (4, 0)
    assert document.redo_label == "move B"


def test_a_drag_back_to_where_it_began_is_no_step(document):
    document.move("C", (5, 5), gesture="7")
    document.move("C", (3, 3), gesture="7")
    assert document.undo_label is None
    document.move("C", (4, 4), gesture="7")
    assert document.undo_label == "move C"


def test_undo_ends_a_gesture(document):
    document.move("C", (5, 5), gesture="7")
    document.undo()
    document.redo()
    document.move("C", (6, 6), gesture="7")
    document.undo()
    assert document.region("C").center == (5, 5)


def test_an_edit_without_effect_is_no_step(document):
    revision = document.revision
    document.move("C", (3.0, 3.0))
    document.rename("C", "C")
    assert (document.revision, document.undo_label) == (revision, None)


def test_an_edit_drops_what_was_undone(document):
    document.delete("C")
    document.undo()
    document.set_seed(5)
    assert document.redo() is None


def test_modified_compares_with_what_was_saved(document):
    assert not document.modified
    document.set_seed(5)
    assert document.modified
    document.mark_saved()
    assert not document.modified
    document.undo()
    assert document.modified


def test_edits_after_the_saved_scene_stay_unsaved(document):
    document.set_seed(5)
    written = document.scene
    document.set_seed(6)
    document.mark_saved(written)
    assert document.modified
    document.undo()
    assert not document.modified


def test_the_oldest_steps_are_forgotten():
    history = History(0)
    for number in range(1, CAPACITY + 11):
        history.record("count", number)
    while history.undo():
        pass
    assert history.present == 10
