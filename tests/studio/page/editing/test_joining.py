"""Regions are joined to one of several parts, edited part by part, and taken apart."""

from dataclasses import replace

import numpy as np
import pytest

from core.errors import UserError
from core.stl import parse, robustness
from scenes import Region
from scenes.distances import margin_of
from studio.page.editing.document import Document
from studio.page.editing.editor import Editor
from studio.page.editing.joining import joined, part_met
from studio.page.editing.selection import INITIAL
from tests.studio.page.editing.draft import scene


@pytest.fixture
def document():
    return Document(scene())


@pytest.fixture
def editor(document):
    editor = Editor(document)
    editor.select("A1")
    return editor


def join(editor, *names):
    editor.join()
    for name in names:
        editor.click(name)


def test_clicked_regions_become_parts_and_the_formula_names_the_whole(document, editor):
    join(editor, "B", INITIAL)
    assert (editor.selection, editor.joining) == (INITIAL, False)
    assert document.scene.region_names == ("A1", "C")
    union = document.region("A1")
    assert [part.kind for part in union.parts] == ["circle", "rectangle"]
    assert document.scene.formula == "F_[0:10](A1) &  G_[0:20]( !A1 )"
    assert document.undo() == "join A1 with B"
    assert document.scene == scene()


def test_several_are_joined_one_after_the_other(document, editor):
    join(editor, "B", "C")
    assert document.scene.region_names == ("A1",)
    assert len(document.region("A1").parts) == 3
    assert editor.joining
    editor.cancel()
    assert (editor.joining, editor.selection) == (False, "A1")


def test_too_many_parts_are_refused():
    circle = Region("A", "circle", (0, 0), (1,))
    union = Region("U", "union", parts=(circle,) * 10)
    assert len(joined(union, circle).parts) == 11
    with pytest.raises(UserError, match="U and U have 20 parts together; .* at most 16"):
        joined(union, union)


def test_a_part_is_moved_copied_and_deleted(document, editor):
    join(editor, "B")
    editor.select("A1", 1)
    rectangle = editor.selected
    assert rectangle is not None and rectangle.kind == "rectangle"
    for phase, at in (("start", (0.0, 0.0)), ("end", (1.0, 0.0))):
        editor.move("A1", phase, (0.0, 0.0), at)
    assert [part.center for part in document.region("A1").parts] == [(1, 2), (1, 0)]
    editor.duplicate()
    assert (len(document.region("A1").parts), editor.part) == (3, 2)
    editor.delete()
    assert (len(document.region("A1").parts), editor.part) == (2, None)
    editor.select("A1", 1)
    editor.delete()
    alone = document.region("A1")
    assert alone == replace(scene().regions[0], color=None)
    assert editor.selected == alone


def test_escape_leaves_the_part_then_the_region(editor):
    join(editor, "B")
    editor.select("A1", 0)
    editor.cancel()
    assert (editor.selection, editor.part) == ("A1", None)
    editor.cancel()
    assert editor.selection is None


def test_a_second_click_selects_the_part_below_the_pointer(editor):
    join(editor, "B")
    editor.cancel()
    down = np.array([0.0, 0.0, -1.0])
    editor.click("A1", (np.array([0.0, 0.0, 9.0]), down))
    assert editor.part == 1
    editor.click("A1", (np.array([1.0, 2.0, 9.0]), down))
    assert editor.part == 0


def test_in_space_a_ray_meets_a_part():
    ball = Region("a", "sphere", (0, 0, 1), (0.5,))
    box = Region("b", "box", (3, 0, 2), (0.5, 0.5, 0.5))
    union = Region("U", "union", parts=(ball, box))
    eye = np.array([0.0, -8.0, 4.0])
    assert part_met(union, eye, np.array([0.0, 0.0, 1.0]) - eye) == 0
    assert part_met(union, eye, np.array([3.0, 0.0, 2.0]) - eye) == 1


def test_taken_apart_the_formula_means_the_same(document, editor):
    join(editor, "B")
    before = document.scene
    editor.take_apart()
    after = document.scene
    assert after.region_names == ("A1", "A2", "C")
    assert after.formula == "F_[0:10]((A1 | A2)) &  G_[0:20]( !(A1 | A2) )"
    assert [region.kind for region in after.regions] == ["circle", "rectangle", "circle"]
    trace = np.random.default_rng(0).uniform(-4, 4, (21, 2))

    def value(scene):
        margins = np.stack([margin_of(region, trace) for region in scene.regions], axis=-1)
        names = scene.region_names
        return float(robustness(parse(scene.formula, dt=0.2, names=names), margins, names))

    assert value(after) == pytest.approx(value(before))
    assert document.undo() == "take A1 apart"
    assert document.scene == before


def test_what_has_no_parts_is_not_taken_apart(document, editor):
    with pytest.raises(UserError, match="A1 has no parts"):
        editor.take_apart()
    document.set_formula("F_[0:10](A1")
    join(editor, "B")
    editor.take_apart()
    assert document.scene.formula == "F_[0:10](A1"  # no formula: nothing to keep the meaning of
