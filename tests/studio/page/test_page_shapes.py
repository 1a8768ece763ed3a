"""In a browser: regions of every kind are shown, drawn by their corners, turned and joined."""

from dataclasses import replace

import pytest

from core.methods.training import TrainingConfig
from scenes import Region, load_task
from studio.page import analyst
from studio.page.app import Studio
from studio.page.views.editing import ABOVE, shown_grips
from studio.page.views.regions import HEIGHT
from studio.page.views.roles import Role
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import wait_for_node, wait_for_text
from tests.studio.page.test_page_editing import LIST, Pointer, press, wait_until_drawn
from tests.studio.waiting import wait_for

L_ROOM = ((0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3))
REGIONS = (
    Region("room", "polygon", points=L_ROOM),
    Region("bar", "rectangle", (-3.0, 2.0), (1.0, 0.2), angle=30.0),
    Region("pair", "union", parts=(Region("a", "circle", (-3, -3), (0.5,)),)),
)
ANGLE = "xpath=//*[normalize-space(text())='Angle (°)']/following::input[1]"
START = Region("initial", "point", (-3.0, 0.0))


@pytest.fixture
def studio(monkeypatch, small_algorithm):
    """A page with a wider arena and a region of each kind."""
    monkeypatch.setattr(analyst.Analyst, "observe", lambda *_: None)
    scene = replace(load_task("linear-demo"), formula="F_[0:60](room)", regions=REGIONS)
    scene = replace(scene, initial=START, arena=((-7.0, 7.0), (-5.0, 5.0)))
    config = TrainingConfig(small_algorithm)
    studio = Studio(scene, None, "127.0.0.1", free_port(), lambda *_, **__: config)
    with running(studio):
        yield studio


def test_a_polygon_is_drawn_among_regions_of_every_kind(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach")
    for node in ("/scene/region0", "/scene/region1", "/scene/region2", "/scene/initial", "/floor"):
        wait_for_node(page, node)
    editor = studio.session.editor
    pointer = Pointer(studio, page)
    press(page, "polygon")
    page.wait_for_selector(f"{LIST} button[aria-pressed=true]:has-text('polygon')")
    corners = ((4.0, -4.0), (6.0, -4.0), (6.0, -2.0), (5.0, -3.0))
    for count, corner in enumerate(corners, start=1):
        page.mouse.click(*pointer._at(*corner))
        assert wait_for(lambda count=count: len(editor.corners) == count)
    page.mouse.click(*pointer._at(*corners[0]))
    wait_for_node(page, "/scene/region3")
    region = studio.session.document.scene.regions[-1]
    assert (region.kind, region.points) == ("polygon", corners)
    assert editor.selection == region.name
    wait_for_text(page, LIST, region.name)


def grip(studio, kind, index=0):
    """Where a handle of what is selected is [3]."""
    height = HEIGHT[Role.UNUSED] + ABOVE
    shown = shown_grips(studio.session.editor, height)
    return next(each.position for each in shown if (each.kind, each.index) == (kind, index))


def choose(studio, page, name):
    """Select a region or a part by its button."""
    before = studio.session.editor.selected
    press(page, name)
    assert wait_for(lambda: studio.session.editor.selected != before)


def test_shapes_are_turned_joined_edited_and_taken_apart(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach")
    wait_for_node(page, "/scene/region2")
    editor, document = studio.session.editor, studio.session.document
    pointer = Pointer(studio, page)

    choose(studio, page, "bar")
    wait_until_drawn(page, "/edit/turn0", grip(studio, "turn"))
    height = grip(studio, "turn")[2]
    pointer.drag(grip(studio, "turn"), (-3.0, 4.0, height))  # straight above the middle
    assert wait_for(lambda: document.undo_label == "turn bar" and not editor.dragging)
    angle = document.region("bar").angle
    assert angle % 5 == 0.0
    assert angle == pytest.approx(0.0, abs=10.0)  # a dot is not grabbed in its very middle
    wait_until_drawn(page, "/edit/turn0", grip(studio, "turn"))
    pointer.drag(grip(studio, "turn"), (-2.0, 3.1, height), key="Shift")
    assert wait_for(lambda: document.region("bar").angle != angle and not editor.dragging)
    turn = document.region("bar").angle - angle
    assert turn % 5 != 0.0
    assert turn == pytest.approx(-42.3, abs=12.0)
    # What is typed into a field that changes meanwhile is added to its new value.
    assert wait_for(
        lambda: float(page.locator(ANGLE).input_value()) == document.region("bar").angle
    )
    page.locator(ANGLE).fill("12.5")
    assert wait_for(lambda: document.region("bar").angle == 12.5)

    press(page, "Join with")
    page.wait_for_selector(f"{LIST} button[aria-pressed=true]:has-text('Join with')")
    press(page, "pair")
    wait_for_text(page, LIST, "2 circle")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Escape")
    choose(studio, page, "2 circle")
    wait_until_drawn(page, "/edit/handle1", grip(studio, "dot", 1))
    pointer.drag(grip(studio, "dot", 1), (-2.0, -3.0, height))
    assert wait_for(lambda: document.region("bar").parts[1].size == (1.0,))
    assert wait_for(lambda: not editor.dragging)
    press(page, "whole")
    press(page, "Take apart")
    page.wait_for_selector(f"{LIST} button:has-text('bar1')")
    assert [region.kind for region in document.scene.regions] == ["polygon", "rectangle", "circle"]
    assert document.region("bar").angle == 12.5


def test_corners_are_added_and_deleted(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach")
    wait_for_node(page, "/scene/region2")
    editor, document = studio.session.editor, studio.session.document
    pointer = Pointer(studio, page)
    choose(studio, page, "room")
    place = (*grip(studio, "edge")[:2], HEIGHT[Role.GOAL] + ABOVE)
    wait_until_drawn(page, "/edit/edge0", place)
    pointer.drag(place, (2.0, -1.0, place[2]))
    assert wait_for(lambda: len(document.region("room").points) == 7 and not editor.dragging)
    assert document.region("room").points[1] == (2.0, -1.0)
    wait_until_drawn(page, "/edit/handle1", (2.0, -1.0, place[2]))
    page.mouse.click(*pointer._at(2.0, -1.0, place[2]))
    assert wait_for(lambda: editor.vertex == 1)
    wait_for_text(page, LIST, "Delete this corner")
    page.keyboard.press("Delete")
    assert wait_for(lambda: document.region("room").points == L_ROOM)
