"""In a browser: regions of every kind are shown; a polygon is drawn by clicks at its corners."""

from dataclasses import replace

import pytest

from core.methods.training import TrainingConfig
from scenes import Region, load_task
from studio.page import analyst
from studio.page.app import Studio
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import wait_for_node, wait_for_text
from tests.studio.page.test_page_editing import LIST, Pointer, press
from tests.studio.waiting import wait_for

L_ROOM = ((0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3))
REGIONS = (
    Region("room", "polygon", points=L_ROOM),
    Region("bar", "rectangle", (-3.0, 2.0), (1.0, 0.2), angle=30.0),
    Region("pair", "union", parts=(Region("a", "circle", (-3, -3), (0.5,)),)),
)
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
