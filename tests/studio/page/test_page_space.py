"""Robots in space in a browser: a click on the map moves them, regions are drawn and pulled."""

import numpy as np
import pytest

from scenes import load_task
from studio.page.app import Studio
from studio.page.views.editing import grips
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import choose_task, click_cell, wait_for_node, wait_for_text
from tests.studio.page.test_page_editing import Pointer, press
from tests.studio.waiting import wait_for

MOVING = {"panda": "/robot/hand", "quadrotor": "/robot", "ant": "/robot/part4"}
"""A node that moves with the robot."""


@pytest.fixture(scope="module")
def studio(disk_cache):
    """One page for all tests; nothing is trained, the demos' policies are shown."""
    studio = Studio(load_task("linear-demo"), None, "127.0.0.1", free_port())
    with running(studio):
        yield studio


def pose(page, node):
    return page.evaluate("n => window.__viserMutable.nodePoseData[n] ?? null", node)


def wait_until_moved(page, node, before):
    page.wait_for_function(
        """([node, before]) => {
            const now = window.__viserMutable.nodePoseData[node];
            return Math.hypot(...now.position.map((x, i) => x - before.position[i])) > 0.02;
        }""",
        arg=[node, before],
    )


@pytest.mark.parametrize("robot", MOVING)
def test_a_click_on_the_map_moves_the_robot(studio, page, robot):
    session = studio.session
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach")
    choose_task(page, f"{robot}-demo")
    wait_for_text(page, ".tg-title", load_task(f"{robot}-demo").title)
    wait_for_node(page, MOVING[robot])

    def schedule():
        recording = session.player.recording
        if recording is None or recording.task.name != f"{robot}-demo":
            return None
        return recording.schedule

    assert wait_for(lambda: schedule() is not None)
    page.wait_for_selector("image.tg-cells")
    chosen = schedule()
    click_cell(page, 0.5, 0.98)
    assert wait_for(lambda: schedule() not in (None, chosen))
    clicked = schedule()
    assert clicked is not None
    assert clicked[0] < clicked[1]
    wait_for_node(page, "/trail")
    session.post(lambda: session.player.seek(0))
    page.wait_for_selector("button:has-text('Play')")
    standing = pose(page, MOVING[robot])
    page.get_by_role("button", name="Play").click()
    wait_until_moved(page, MOVING[robot], standing)
    assert session.error == ""


def test_regions_in_space_are_drawn_moved_and_resized(studio, page):
    session = studio.session
    session.post(lambda: session.choose_task("quadrotor-08"))
    assert wait_for(lambda: session.document.scene.name == "quadrotor-08")
    page.goto(studio.url)
    wait_for_node(page, "/scene/region9")
    wait_for_node(page, "/floor")
    pointer = Pointer(studio, page)

    def last():
        return session.document.scene.regions[-1]

    def grip(index):
        return np.array(grips(last(), 0.0, 1.0)[index].position)

    kinds = ("box", "sphere", "cylinder")
    places = ((-3.8, -1.5), (-1.8, -2.8), (0.0, -2.8))  # no panel lies over them
    for count, (kind, (x, y)) in enumerate(zip(kinds, places, strict=True), start=10):
        press(page, kind)
        page.wait_for_selector(f".tg-regions button[aria-pressed=true]:has-text('{kind}')")
        pointer.drag((x, y), (x + 0.5, y + 0.5))
        wait_for_node(page, f"/scene/region{count}")
        assert last().kind == kind
        bottom = last().center[2] - last().size[-1]
        assert bottom == pytest.approx(0.0, abs=0.15)  # a sphere's radius is off the grid

    wait_for_node(page, "/edit/arrow2")
    before = last()
    up = grip(-1) + [0.0, 0.0, 0.3]
    pointer.drag(up, up + [0.0, 0.0, 1.5])
    assert wait_for(lambda: session.document.undo_label == f"move {before.name}")
    assert wait_for(lambda: not session.editor.dragging)
    assert last().center[:2] == before.center[:2]
    assert last().center[2] == pytest.approx(before.center[2] + 1.5, abs=0.26)
    page.wait_for_function(
        """([node, z]) => Math.abs(
            window.__viserMutable.nodePoseData[node].position[2] - z) < 1e-3""",
        arg=["/scene/region12", last().center[2]],
    )

    lifted, top = last(), grip(5)
    pointer.drag(top, top + [0.0, 0.0, 0.5])
    assert wait_for(lambda: session.document.undo_label == f"resize {before.name}")
    assert wait_for(lambda: not session.editor.dragging)
    assert last().size[1] > lifted.size[1]
    floor = [region.center[2] - region.size[1] for region in (lifted, last())]
    assert floor[0] == pytest.approx(floor[1])

    press(page, "Duplicate")
    wait_for_node(page, "/scene/region13")
    for _ in range(3):
        press(page, "↶")
    assert wait_for(lambda: last() == before)
