"""The page in a browser: the map's switch, and that a click plays what the map says."""

import re

import pytest

from scenes import load_task
from studio.page.app import Studio
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import click_cell, map_box, schedule_shown, wait_for_text
from tests.studio.waiting import wait_for


@pytest.fixture
def studio(disk_cache):
    """A page with the robot's shipped weights."""
    studio = Studio(load_task("linear-demo"), None, "127.0.0.1", free_port())
    with running(studio):
        yield studio


def read_out(page, horizontal, vertical):
    """What the map says of a cell, at shares of its width and height from the lower left."""
    box = map_box(page)
    across, up = horizontal * box["width"], (1 - vertical) * box["height"]
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"])
    page.mouse.move(box["x"] + across, box["y"] + up)
    return page.locator(".tg-map .tg-readout").inner_text()


def test_the_switch_shows_what_a_click_then_plays(studio, page):
    page.goto(studio.url)
    page.wait_for_selector("image.tg-cells")
    page.get_by_role("button", name="Simulated", exact=True).click()
    wait_for_text(page, ".tg-truth", "of 576 schedules satisfy the formula; rank correlation")
    for corner, schedule in [(0.98, "t1 = 60, t2 = 0"), (0.02, "t1 = 0, t2 = 0")]:
        # The read-out is empty again whenever the map is drawn anew.
        assert wait_for(lambda at=corner, text=schedule: text in read_out(page, at, 0.02))
        said = read_out(page, corner, 0.02)
        found = re.search(r"(satisfied|fails) with robustness (-?[\d.]+) m, value", said)
        assert found, said
        click_cell(page, corner, 0.02)
        schedule_shown(page, schedule)
        recording = studio.session.player.recording
        assert float(found[2]) == pytest.approx(recording.robustness, abs=6e-4)
        assert (found[1] == "satisfied") == recording.satisfied

    page.get_by_role("button", name="Critic", exact=True).click()
    page.wait_for_function("!document.querySelector('.tg-truth')")
    assert not studio.session.analyst.simulating
