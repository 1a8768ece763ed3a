from types import SimpleNamespace

import pytest

from scenes import load_task
from studio.page.editing.document import Document
from studio.page.editing.editor import Editor
from studio.page.editing.selection import INITIAL
from studio.page.panels.regions import press


@pytest.fixture
def session():
    document = Document(load_task("linear-08"))
    return SimpleNamespace(
        document=document, editor=Editor(document), undo=document.undo, redo=document.redo
    )


def test_the_list_selects_and_deselects(session):
    press(session, "region 1")
    assert session.editor.selection == "A2"
    press(session, "region 1")
    assert session.editor.selection is None
    press(session, "initial")
    assert session.editor.selection == INITIAL


def test_buttons_edit_and_undo(session):
    press(session, "region 0")
    press(session, "duplicate")
    assert session.document.scene.region_names[-1] == "A4"
    press(session, "delete")
    press(session, "undo")
    press(session, "undo")
    assert session.document.scene == load_task("linear-08")
    press(session, "redo")
    assert "A4" in session.document.scene.region_names


def test_a_button_takes_a_tool(session):
    press(session, "tool circle")
    assert session.editor.tool == "circle"


@pytest.mark.parametrize(
    "value", ["", "region", "region -1", "region 99", "region ²", "tool x", "x"]
)
def test_what_no_button_sends_is_ignored(session, value):
    press(session, "region 0")
    press(session, value)
    assert session.editor.selection == "A1"
    assert session.document.revision == 0
