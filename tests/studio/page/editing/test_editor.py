from dataclasses import replace

import pytest

from core.errors import UserError
from scenes import Region, load_task
from studio.page.editing.document import Document
from studio.page.editing.editor import SELECT, Editor
from studio.page.editing.selection import INITIAL
from studio.page.editing.shapes import handles


@pytest.fixture
def document():
    return Document(load_task("linear-08"))


@pytest.fixture
def editor(document):
    return Editor(document)


def drag(act, *points):
    """Feed a drag through `points`: start at the first, end at the last."""
    act("start", points[0])
    for point in points:
        act("update", point)
    act("end", points[-1])


def move(editor, target, *points):
    drag(lambda phase, point: editor.move(target, phase, points[0], point), *points)


def draw(editor, *points):
    drag(lambda phase, point: editor.draw(phase, points[0], point), *points)


def test_a_move_snaps_to_the_grid_and_is_one_step(document, editor):
    move(editor, "A1", (-3.1, 2.9, 0.03), (-2.0, 2.0, 0.03), (-1.11, 0.93, 0.03))
    assert document.region("A1").center == (-1.0, 0.75)
    assert editor.selection == "A1"
    assert not editor.dragging
    document.undo()
    assert document.region("A1").center == (-3.0, 2.8)
    assert document.undo_label is None


def test_a_move_that_ends_where_it_began_is_no_step(document, editor):
    move(editor, "A1", (0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 0.0))
    assert document.undo_label is None


def test_without_a_grid_a_region_follows_exactly(document, editor):
    editor.step = 0.0
    move(editor, "A1", (0.0, 0.0, 0.0), (0.123, -0.2, 0.0))
    assert document.region("A1").center == pytest.approx((-2.877, 2.6))


def test_a_handle_resizes(document, editor):
    editor.select("B5")
    drag(lambda phase, point: editor.resize(3, phase, point), (3.1, 0.6, 0.1), (3.4, 1.1, 0.1))
    region = document.region("B5")
    assert region.center[0] + region.size[0] == pytest.approx(3.5)
    assert region.center[1] + region.size[1] == pytest.approx(1.0)
    assert region.center[0] - region.size[0] == pytest.approx(-1.3)


def test_the_initial_set_moves_too(document, editor):
    before = document.scene.initial.center
    move(editor, INITIAL, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert document.scene.initial.center == pytest.approx((before[0] + 1.0, before[1]))


def test_drawing_shows_a_preview_and_adds_a_region(document, editor):
    editor.take("circle")
    editor.draw("start", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    editor.draw("update", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert editor.preview is not None
    assert editor.preview.size == (1.0,)
    editor.draw("end", (0.0, 0.0, 0.0), (1.5, 0.0, 0.0))
    assert editor.preview is None
    assert (editor.selection, editor.tool) == ("A4", SELECT)
    assert document.region("A4").size == (1.5,)


def test_a_drag_too_short_adds_nothing(document, editor):
    draw(editor, (0.0, 0.0, 0.0), (0.01, 0.01, 0.0))
    assert document.revision == 0


def test_without_a_tool_a_drag_draws_a_rectangle(document, editor):
    draw(editor, (0.0, 0.0, 0.0), (1.0, 2.0, 0.0))
    region = document.region("A4")
    assert (region.kind, region.center, region.size) == ("rectangle", (0.5, 1.0), (0.5, 1.0))


def test_escape_takes_a_drag_back_and_the_rest_of_it_does_nothing(document, editor):
    editor.move("A1", "start", (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    editor.move("A1", "update", (0.0, 0.0, 0.0), (1.0, 1.0, 0.0))
    assert document.region("A1").center == (-2.0, 3.75)
    editor.cancel()
    for phase in ("update", "end"):
        editor.move("A1", phase, (0.0, 0.0, 0.0), (2.0, 1.0, 0.0))
    assert document.region("A1").center == (-3.0, 2.8)
    assert document.undo_label is None


def test_escape_while_drawing_adds_nothing(document, editor):
    editor.take("rectangle")
    editor.draw("start", (0.0, 0.0), (0.0, 0.0))
    editor.draw("update", (0.0, 0.0), (1.0, 1.0))
    editor.cancel()
    editor.draw("end", (0.0, 0.0), (1.0, 1.0))
    assert editor.preview is None
    assert document.revision == 0
    editor.cancel()
    assert editor.tool == SELECT


def test_the_selected_region_is_duplicated_deleted_and_made_the_start(document, editor):
    editor.select("A1")
    editor.duplicate()
    assert editor.selection == "A4"
    editor.make_initial()
    assert document.scene.initial.center == document.region("A4").center
    assert document.scene.initial.kind == "circle"
    editor.delete()
    assert editor.selection is None
    assert "A4" not in document.scene.region_names


def test_the_initial_set_is_neither_deleted_nor_duplicated(document, editor):
    editor.select(INITIAL)
    editor.delete()
    editor.duplicate()
    assert document.revision == 0


def test_a_region_that_is_gone_is_not_selected(document, editor):
    editor.select("A1")
    document.replace(replace(document.scene, regions=document.scene.regions[1:]), "drop A1")
    editor.check_selection()
    assert editor.selection is None
    editor.select("A1")
    assert editor.selection is None


def test_tools_of_another_dimension_are_refused(editor):
    editor.take("sphere")
    assert editor.tool == SELECT


@pytest.mark.parametrize("kind", ["rectangle", "circle"])
def test_a_region_is_added_in_the_middle(document, editor, kind):
    editor.add(kind)
    assert document.region("A4").kind == kind
    assert document.region("A4").center == (0.0, 0.0)


def _click(editor, *points):
    for point in points:
        editor.corner((*point, 0.0))


def test_a_polygon_is_drawn_by_its_corners(document, editor):
    editor.take("polygon")
    _click(editor, (0.02, 0), (2, 0), (2, 0), (2, 1), (1, 1.01))
    assert editor.corners == ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0))
    editor.cancel()
    assert editor.corners == ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0))
    _click(editor, (0.1, 0.1))  # the first corner again
    region = document.region(editor.selection)
    assert region.points == ((0.0, 0.0), (2.0, 0.0), (2.0, 1.0))
    assert (editor.tool, editor.corners) == (SELECT, ())
    document.undo()
    assert region.name not in document.scene.region_names


def test_a_polygon_that_crosses_itself_keeps_its_corners(document, editor):
    editor.take("polygon")
    _click(editor, (0, 0), (1, 1))
    with pytest.raises(UserError, match="2 corners; a polygon has from 3"):
        editor.close()
    _click(editor, (1, 0), (0, 1))
    with pytest.raises(UserError, match="touch or cross"):
        editor.close()
    assert len(editor.corners) == 4 and editor.tool == "polygon"
    assert document.revision == 0


def test_clicks_without_the_tool_draw_nothing(document, editor):
    _click(editor, (0, 0), (1, 1))
    editor.close()
    assert (editor.corners, document.revision) == ((), 0)


def test_corners_turn_with_their_rectangle(document, editor):
    editor.select("A1")
    document.put("A1", Region("A1", "rectangle", (0, 0), (2, 1), angle=90.0), "change")
    corner = next(i for i, p in enumerate(handles(document.region("A1"))) if p[0] > 0 < p[1])
    editor.step = 0.0
    for phase in ("start", "update", "end"):
        editor.resize(corner, phase, (1.5, 3.0))
    region = document.region("A1")
    assert (region.angle, handles(region)[corner]) == (90.0, pytest.approx((1.5, 3.0)))
