"""The page in a browser: what rollouts leave on screen, and what the tables say about them."""

import pytest

from core.methods.training import TrainingConfig
from scenes import load_task
from studio.page.app import Studio
from studio.page.asking import SAMPLE
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import (
    click_cell,
    robot_at,
    schedule_shown,
    wait_for_node,
    wait_for_text,
    wait_until_robot_leaves,
)

FORMULA = "F_[0:90](A1) & F_[40:80](A2) & G_[0:100](!B5)"
LEAF_FILLS = """() => [...document.querySelectorAll('.tg-leaf')].map(
    leaf => getComputedStyle(leaf.querySelector('rect')).fill)"""

HOLDING, VIOLATED = "rgb(235, 251, 238)", "rgb(255, 201, 201)"


@pytest.fixture
def studio(small_algorithm):
    """A page that has trained for two epochs of a small algorithm."""

    def make_config(scene, time_limit):
        return TrainingConfig(small_algorithm, seed=scene.seed, epochs=2, target=2.0)

    studio = Studio(load_task("linear-07"), FORMULA, "127.0.0.1", free_port(), make_config)
    studio.session.post(studio.session.train)
    with running(studio):
        yield studio


def wait_for_leaf(page, color):
    page.wait_for_function(f"color => ({LEAF_FILLS})().includes(color)", arg=color)


def legend(page):
    return page.locator(".tg-chip:not(.tg-kind)").all_inner_texts()


def test_rollouts_stay_as_ghosts_and_say_what_failed(studio, page):
    page.goto(studio.url)
    page.wait_for_selector("image.tg-cells")
    wait_for_text(page, ".tg-verdict", "robustness")
    assert not legend(page)  # a plan that nobody asked for leaves no ghost

    click_cell(page, 0.001, 0.99)
    schedule_shown(page, "t1 = 0, t2 = 80")
    click_cell(page, 0.999, 0.01)
    schedule_shown(page, "t1 = 90, t2 = 40")
    wait_for_text(page, ".tg-legend", "t1 = 90")
    texts = legend(page)
    assert len(texts) == 2
    assert "t1 = 0, t2 = 80" in texts[0]
    wait_for_node(page, "/ghosts/0")
    wait_for_node(page, "/ghosts/1")
    one, other = (ghost.recording for ghost in studio.session.gallery.ghosts)
    assert abs(one.positions - other.positions).max() > 1e-4

    page.locator(".tg-chip:not(.tg-kind)").first.click()
    schedule_shown(page, "t1 = 0, t2 = 80")

    page.get_by_role("tab", name="Monitor").click()
    wait_for_text(page, ".tg-monitor", "A1")
    sentence = page.locator(".tg-sentence").inner_text()
    assert sentence.startswith(("Violated: ", "Satisfied"))
    rows = page.locator("image.tg-cells-monitor")
    assert rows.count() == len(one.rows)
    rows.nth(2).click()
    wait_for_text(page, ".tg-monitor .tg-readout", "for A1")
    page.wait_for_function("document.querySelector('.tg-playhead')")
    page.get_by_role("tab", name="Rollout").click()

    studio.session.post(lambda: studio.session.player.seek(0))
    wait_for_leaf(page, HOLDING)
    standing = robot_at(page)
    studio.session.post(lambda: studio.session.player.seek(1000))
    wait_for_leaf(page, VIOLATED)
    page.wait_for_function(f"color => !({LEAF_FILLS})().includes(color)", arg=HOLDING)
    wait_until_robot_leaves(page, standing)

    page.locator(".tg-leaf").first.hover()
    wait_for_node(page, "/highlight/region0")

    page.get_by_role("button", name=f"{SAMPLE} random starts").click()
    wait_for_text(page, ".tg-sample", f"of {SAMPLE} random starts")
    wait_for_node(page, f"/sample/{SAMPLE - 1}")
    count = int(page.locator(".tg-sample").inner_text().split()[0])
    assert count == studio.session.gallery.successes
