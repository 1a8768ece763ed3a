"""The path of a region as a text, and what the document makes of it."""

from types import SimpleNamespace
from typing import Any

import pytest

from core.errors import UserError
from scenes import Region, load_task
from scenes.motion import Motion, along
from studio.page.editing.document import Document
from studio.page.panels.path_field import PathField, path_text, read_path

DISC = Region("A1", "circle", (1.0, 0.5), (0.5,))


@pytest.mark.parametrize(
    ("text", "motion", "begins"),
    [
        ("0: 0, 0; 20: 3, 0", Motion((0, 20), ((0.0, 0.0), (3.0, 0.0))), (0.0, 0.0)),
        (" 5:1 -1 ;9: 2,2; ", Motion((5, 9), ((0.0, 0.0), (1.0, 3.0))), (1.0, -1.0)),
        ("0.1, 0 per step", along([0.1, 0.0], 2), (1.0, 0.5)),
        ("", None, (1.0, 0.5)),
    ],
)
def test_a_text_is_a_path(text, motion, begins):
    assert read_path(text, DISC) == (motion, begins)


@pytest.mark.parametrize(
    "text", ["0: 0, 0; 20: 3, 0.25", "3: 1, 1; 5: 2, -2; 9: 0, 0", "-0.1, 0.05 per step", ""]
)
def test_a_path_is_shown_as_it_is_typed(text):
    motion, begins = read_path(text, DISC)
    moving = Region("A1", "circle", begins, (0.5,), motion=motion)
    assert path_text(moving) == text
    assert read_path(path_text(moving), moving) == (motion, begins)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0, 0; 20, 3", "'0, 0' must be a step, a colon and a position, as in 0: 0, 0; 20: 3, 0"),
        ("0: 0, 0; -2: 3, 0", "'-2: 3, 0': the step must be a whole number from 0 on"),
        ("0: 0, 0; 2.5: 3, 0", "the step must be a whole number from 0 on"),
        ("0: 0, 0; 20: 3, east", "'3, east' must be numbers"),
        ("0: 0, 0; 20: 3", "has 2 numbers; a waypoint is [step, x, y]"),
        ("0: 0, 0", "1 waypoints; from 2 to 64 are allowed"),
        ("9: 0, 0; 2: 1, 1", "step 2 does not come after step 9"),
        ("0.1 per step", "has 1 numbers; expected 2"),
        ("fast per step", "'fast' must be numbers, 0.1, 0 per step"),
    ],
)
def test_errors_say_what_is_allowed(text, words):
    with pytest.raises(UserError) as found:
        read_path(text, DISC)
    assert words in str(found.value)


@pytest.fixture
def document():
    return Document(load_task("linear-demo"))


def test_a_region_keeps_its_path_whatever_else_changes(document):
    name = document.scene.region_names[0]
    motion = Motion((0, 20), ((0.0, 0.0), (3.0, 0.0)))
    document.set_motion(name, motion, (0.0, 0.0))
    document.move(name, (1.0, 1.0))
    document.recolor(name, "#123456")
    document.reshape(name, "rectangle", (1.0, 1.0), (0.5, 0.2))
    document.rename(name, "moved")
    assert document.region("moved").displaced(20).center == (4.0, 1.0)
    copy = document.duplicate("moved")
    assert document.region(copy).motion == motion


def test_a_path_is_undone_and_makes_a_training_stale(document):
    name, trained = document.scene.region_names[0], document.scene
    document.set_motion(name, along([0.1, 0.0], 2), document.region(name).center)
    assert not document.matches(trained)
    assert document.undo() == f"change the path of {name}"
    assert document.matches(trained)


def test_a_region_that_becomes_the_initial_set_stands(document):
    name = document.scene.region_names[0]
    document.set_motion(name, along([0.1, 0.0], 2), (0.0, 0.0))
    document.put("", document.region(name), "change")
    assert document.scene.initial.motion is None


def test_what_is_wrong_changes_nothing_and_is_said(document):
    name, before = document.scene.region_names[0], document.scene
    session: Any = SimpleNamespace(document=document)
    field = PathField.__new__(PathField)
    field.apply(session, name, "0: 0, 0; 20")
    assert "must be a step, a colon and a position" in field._wrong
    assert document.scene is before
    field.apply(session, name, "0: 0, 0; 20: 3, 0")
    assert not field._wrong and document.region(name).motion is not None
