"""The edited document: what edits change, and which are refused."""

import math
from dataclasses import replace

import pytest

from core.errors import UserError
from core.task.grounding import MAX_ATOMS
from scenes import Region, format_scene, parse_scene
from studio.page.editing.document import EditError, free_name
from tests.studio.page.editing.draft import scene


def test_new_regions_get_the_first_free_name(document):
    assert document.add("circle", (0, 0), (1,)) == "A2"
    assert document.add("rectangle", (0, 0), (1, 1), color="#ff0000") == "A3"
    document.delete("A2")
    assert document.add("circle", (0, 0), (1,)) == "A2"
    assert document.add("circle", (0, 0), (1,), prefix="B") == "B1"
    assert document.scene.region_names == ("A1", "B", "C", "A3", "A2", "B1")


def test_free_names_stay_within_the_longest():
    assert free_name("x" * 60, []) == "x" * 39 + "1"
    assert free_name("x" * 60, ["x" * 39 + str(n) for n in range(1, 10)]) == "x" * 38 + "10"


def test_edits_change_one_thing(document):
    document.move("C", (1.5, -1))
    document.resize("C", (0.7,))
    document.resize("B", (2, 1), center=(1, 1))
    document.recolor("C", "#00ff00")
    document.reshape("A1", "rectangle", (1, 2), (0.5, 0.6))
    document.set_initial(size=(0.1, 0.2))
    document.set_horizon(30)
    document.set_seed(7)
    document.set_title("Other")
    now = document.scene
    assert now.regions == (
        Region("A1", "rectangle", (1, 2), (0.5, 0.6)),
        Region("B", "rectangle", (1, 1), (2, 1), "#123456"),
        Region("C", "circle", (1.5, -1), (0.7,), "#00ff00"),
    )
    assert now.initial == Region("initial", "rectangle", (-3, -3), (0.1, 0.2))
    assert (now.horizon, now.seed, now.title, now.formula) == (30, 7, "Other", scene().formula)


def test_a_duplicate_lies_aside_under_its_own_name(document):
    assert document.duplicate("B") == "B1"
    assert document.duplicate("A1") == "A2"
    assert document.region("B1") == replace(document.region("B"), name="B1", center=(0.4, -0.4))
    assert document.region("A2").center == pytest.approx((1.4, 1.6))


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda d: d.move("D", (0, 0)), "unknown 'D'. Allowed: "),
        (lambda d: d.move("C", (0, math.nan)), "center"),
        (lambda d: d.move("C", (0, 0, 0)), "3 numbers"),
        (lambda d: d.resize("C", (0,)), "positive"),
        (lambda d: d.recolor("C", "red"), "#rrggbb"),
        (lambda d: d.rename("C", "B"), "another region"),
        (lambda d: d.rename("C", "  "), "name"),
        (lambda d: d.add("cube", (0, 0), (1,)), "Allowed"),
        (lambda d: d.add("sphere", (0, 0, 0), (1,)), "dimension"),
        (lambda d: d.set_formula(" "), "formula"),
        (lambda d: d.set_horizon(0), "horizon"),
        (lambda d: d.set_seed(-1), "seed"),
        (lambda d: d.set_title(""), "title"),
        (lambda d: d.set_initial(size=(1, -1)), "positive"),
    ],
)
def test_bad_edits_are_refused_as_a_whole(document, edit, message):
    with pytest.raises(UserError, match=message):
        edit(document)
    assert document.scene == scene()
    assert document.undo_label is None


def test_no_more_regions_than_a_formula_can_name(document):
    while len(document.scene.regions) < MAX_ATOMS:
        document.add("circle", (0, 0), (1,))
    for edit in (lambda: document.add("circle", (0, 0), (1,)), lambda: document.duplicate("B")):
        with pytest.raises(EditError, match=f"at most {MAX_ATOMS} regions"):
            edit()


def test_a_scene_without_regions_can_be_kept():
    empty = replace(scene(), regions=())
    assert parse_scene(format_scene(empty), "file") == empty
