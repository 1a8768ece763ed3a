"""Regions are turned about the vertical axis, as a rigid body is."""

import numpy as np
import pytest

from scenes import Region
from scenes.distances import margin_of
from studio.page.editing.document import Document
from studio.page.editing.editor import Editor
from studio.page.editing.turning import plain, rotated, turn_between, turn_handle, turned
from tests.scenes.outlines import planar, spatial
from tests.studio.page.editing.draft import scene


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("dimension", [2, 3])
def test_margins_turn_with_the_region(seed, dimension):
    random = np.random.default_rng(seed)
    for flat in planar(random):
        region = flat if dimension == 2 else spatial(flat, 0.0, 1.0)
        degrees = float(random.uniform(-180, 180))
        pivot = tuple(random.uniform(-2, 2, dimension).tolist())
        positions = random.uniform(-3, 3, (200, dimension))
        moved = np.array([rotated(tuple(p), degrees, pivot) for p in positions])
        after = margin_of(turned(region, degrees, pivot), moved)
        assert after == pytest.approx(margin_of(region, positions), abs=1e-7)


def test_angles_are_plain():
    assert [plain(a) for a in (0, 180, -180, 190, 359.9, -725)] == [0, 180, 180, -170, -0.1, -5]


def test_a_drag_snaps_to_five_degrees_unless_it_is_fine():
    bar = Region("A", "rectangle", (1, 1), (2, 0.5), angle=7.0)
    start = (1.0, 3.0, 0.1)
    to = rotated((1.0, 3.0), 31.0, (1.0, 1.0))
    assert 7.0 + turn_between(bar, start, to) == pytest.approx(40.0)
    assert turn_between(bar, start, to, fine=True) == pytest.approx(31.0)
    polygon = Region("P", "polygon", points=((0, 0), (2, 0), (0, 2)))
    assert turn_between(polygon, (1.0, 3.0), rotated((1.0, 3.0), 31.0, (1.0, 1.0))) == 30.0


def test_the_handle_is_outside_and_goes_round():
    bar = Region("A", "rectangle", (1, 1), (2, 0.5))
    handle = turn_handle(bar, 1.0)
    assert handle == pytest.approx((1.0, 2.1))
    assert turn_handle(turned(bar, 90.0, bar.center), 1.0) == pytest.approx((-0.1, 1.0))
    box = Region("A", "box", (1, 1, 3), (2, 0.5, 1))
    handle = turn_handle(box, 1.0)
    assert handle is not None and handle[0] > 3 and handle[1] > 1.5 and handle[2] == 3
    assert turn_handle(Region("A", "circle", (0, 0), (1,)), 1.0) is None
    assert turn_handle(Region("A", "point", (0, 0)), 1.0) is None


def test_turning_by_the_handle_is_one_step_and_the_handle_follows():
    document = Document(scene())
    editor = Editor(document)
    editor.select("B")
    begin = editor.turn_handle
    assert begin is not None
    editor.turn("start", begin)
    for degrees in (10, 33, 88):
        to = rotated(begin, degrees, (0.0, 0.0))
        editor.turn("update", to)
        assert editor.turn_handle == pytest.approx(to, abs=0.1)
    editor.turn("end", rotated(begin, 88, (0.0, 0.0)))
    assert document.region("B").angle == 90.0
    assert document.undo() == "turn B"
    assert document.scene == scene()


def test_a_polygon_turns_about_where_its_middle_was():
    document = Document(scene())
    document.put("C", Region("C", "polygon", points=((0, 0), (2, 0), (2, 1), (0, 1))), "change")
    editor = Editor(document)
    editor.select("C")
    begin = editor.turn_handle
    assert begin is not None
    assert begin == pytest.approx((1.0, 1.1 + 0.5))
    for phase in ("start", "update", "end"):
        editor.turn(phase, begin if phase == "start" else (-3.0, 0.5))
    corners = {(1.5, -0.5), (1.5, 1.5), (0.5, 1.5), (0.5, -0.5)}
    assert {tuple(np.round(p, 6).tolist()) for p in document.region("C").points} == corners
    editor.cancel()
    assert editor.selection is None
