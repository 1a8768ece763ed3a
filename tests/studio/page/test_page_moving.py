"""The robot is dragged with the mouse while its rollout plays; every page shows what follows."""

import numpy as np
import pytest

from scenes import load_task
from studio.page.app import Studio
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import wait_for_node, wait_for_text
from tests.studio.page.test_page_editing import Pointer
from tests.studio.waiting import wait_for


@pytest.fixture
def studio(disk_cache):
    """A page with the robot's shipped weights."""
    studio = Studio(load_task("linear-demo"), None, "127.0.0.1", free_port())
    with running(studio):
        yield studio


def take_and_put(studio, page, step, place):
    """Pause at a step, drag the robot to a place on the floor, and wait for the new rollout."""
    session = studio.session
    before = session.player.recording
    session.post(lambda: session.player.seek(step))
    here = before.positions[step]
    page.wait_for_function(
        """([x, y]) => {
            const pose = window.__viserMutable.nodePoseData['/grip'];
            return pose && Math.hypot(pose.position[0] - x, pose.position[1] - y) < 1e-3;
        }""",
        arg=here[:2].tolist(),
    )
    Pointer(studio, page).drag(here[:2], place)
    assert wait_for(lambda: session.player.recording is not before), session.error
    return before, session.player.recording


def test_a_robot_that_is_dragged_goes_on_from_there(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-plan", "Planned without training")
    wait_for_node(page, "/grip")
    second = page.context.browser.new_page()
    second.goto(studio.url)
    wait_for_text(second, ".tg-plan", "Planned without training")

    before, after = take_and_put(studio, page, 12, (-4.0, 3.0))
    np.testing.assert_array_equal(after.states[:13], before.states[:13])
    np.testing.assert_allclose(after.positions[13, :2], (-4.0, 3.0), atol=0.3)
    assert after.moves == (13,)
    for each in (page, second):
        wait_for_text(each, ".tg-plan", "Moved at step 13; planned anew in")
        wait_for_text(each, ".tg-verdict", "Satisfied")
        each.wait_for_selector(".tg-verdict line.tg-moved", state="attached")
    assert studio.session.error == ""

    take_and_put(studio, page, 20, (0.3, 0.3))
    for each in (page, second):
        text = "Moved at step 21. Nothing can satisfy the formula any more: the robot was in B"
        each.wait_for_selector(f"text={text}")
        wait_for_text(each, ".tg-verdict", "Violated")
    second.close()
