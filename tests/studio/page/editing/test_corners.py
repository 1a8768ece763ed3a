"""Corners of polygons and prisms are dragged, added and taken away."""

import pytest

from core.errors import UserError
from scenes import Region
from scenes.polygons import MOST_CORNERS
from studio.page.editing.corners import corners_of, middles_of, without_corner
from studio.page.editing.document import Document
from studio.page.editing.editor import Editor
from studio.page.editing.shapes import axis_of, handles, reshaped
from tests.studio.page.editing.draft import scene

SQUARE = ((0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0))
PRISM = Region("P", "prism", points=SQUARE, z=(1.0, 2.0))


@pytest.fixture
def editor():
    document = Document(scene())
    document.put("C", Region("C", "polygon", points=SQUARE), "change")
    editor = Editor(document)
    editor.select("C")
    return editor


def points(editor):
    assert editor.selected is not None
    return editor.selected.points


def drag(act, *places):
    act("start", places[0])
    for place in places:
        act("update", place)
    act("end", places[-1])


def test_a_prism_has_its_corners_and_its_two_ends():
    assert handles(PRISM) == (*((*p, 1.5) for p in SQUARE), (1, 1, 1), (1, 1, 2))
    assert [axis_of(PRISM, index) for index in range(6)] == [None] * 4 + [2, 2]
    assert reshaped(PRISM, 2, (3.0, 4.0, 9.0)).points == (*SQUARE[:2], (3.0, 4.0), SQUARE[3])
    assert reshaped(PRISM, 5, (7.0, 7.0, 3.0)).z == pytest.approx((1.0, 3.0))
    assert reshaped(PRISM, 4, (7.0, 7.0, 0.5)).z == pytest.approx((0.5, 2.0))


def test_the_middles_of_edges_are_where_corners_are_added():
    polygon = Region("P", "polygon", points=SQUARE)
    assert middles_of(polygon) == ((1, 0), (2, 1), (1, 2), (0, 1))
    assert middles_of(PRISM)[0] == (1, 0, 1.5)
    ring = [(i, 0.0) for i in range(MOST_CORNERS - 1)] + [(3.0, 5.0)]
    assert middles_of(Region("P", "polygon", points=(*ring,))) == ()
    circle = Region("C", "circle", (0, 0), (1,))
    assert (corners_of(circle), middles_of(circle)) == ((), ())


def test_a_corner_is_dragged_out_of_an_edge_as_one_step(editor):
    drag(lambda phase, at: editor.add_corner(1, phase, at), (2.0, 1.0), (3.0, 1.2), (4.0, 1.0))
    assert points(editor) == (*SQUARE[:2], (4.0, 1.0), *SQUARE[2:])
    assert editor._document.undo() == "change C"
    assert points(editor) == SQUARE


def test_a_new_corner_that_would_cross_an_edge_stays_away(editor):
    drag(lambda phase, at: editor.add_corner(1, phase, at), (2.0, 1.0), (-1.0, 1.0))
    assert points(editor) == SQUARE


def test_the_selected_corner_is_deleted_before_the_region(editor):
    editor.vertex = 1
    editor.delete()
    assert points(editor) == (SQUARE[0], *SQUARE[2:])
    assert editor.vertex is None
    editor.vertex = 0
    with pytest.raises(UserError, match="without this corner: 2 corners"):
        editor.delete()
    editor.cancel()
    assert (editor.vertex, editor.selection) == (None, "C")
    editor.delete()
    assert "C" not in editor._document.scene.region_names


def test_what_would_cross_itself_is_refused():
    dart = ((0, 0), (2, -3), (4, 0), (4, 3), (2, -1), (0, 3))
    region = Region("A", "polygon", points=dart)
    assert without_corner(region, 4).points == (*dart[:4], dart[5])
    with pytest.raises(UserError, match="without this corner: its edges touch or cross"):
        without_corner(region, 1)
