"""The page in a browser: one walk from a typed formula to two rollouts on screen.

What is on screen is read from the page's text and from the viewer's scene graph, never from
pixels; every wait polls for what should happen.
"""

import pytest

from core.methods.training import TrainingConfig
from scenes import load_task
from studio.page.app import Studio
from tests.studio.conftest import free_port, running
from tests.studio.waiting import wait_for

EDITOR = "textarea.mantine-Textarea-input"
FORMULA = "F_[0:90](A1) & F_[40:80](A2) & G_[0:100](!B5)"
WRONG = "F_[0:90](A1) & F_[40:80](A7)"


@pytest.fixture
def studio(small_algorithm):
    """A page whose trainings are small and last until they are stopped."""

    def make_config(scene, time_limit):
        return TrainingConfig(small_algorithm, seed=scene.seed, epochs=100_000, target=2.0)

    studio = Studio(load_task("linear-08"), None, "127.0.0.1", free_port(), make_config)
    with running(studio):
        yield studio


def choose_task(page, name):
    page.locator("input[aria-haspopup=listbox]:visible").first.click()
    page.get_by_role("option", name=name, exact=True).click()


def wait_for_text(page, selector, text):
    page.wait_for_function(
        "([selector, text]) => document.querySelector(selector)?.textContent.includes(text)",
        arg=[selector, text],
    )


def wait_for_node(page, name):
    page.wait_for_function("name => name in (window.__viserSceneTree?.getState() ?? {})", arg=name)


def robot_at(page):
    """Where the viewer's scene graph has the robot [m]."""
    return page.evaluate("window.__viserMutable.nodePoseData['/robot']?.position ?? null")


def wait_until_robot_leaves(page, position):
    page.wait_for_function(
        """([x, y]) => {
            const pose = window.__viserMutable.nodePoseData['/robot'];
            return pose && Math.hypot(pose.position[0] - x, pose.position[1] - y) > 1e-3;
        }""",
        arg=position[:2],
    )


def map_box(page):
    """Where the map is on the screen; it is away for a moment whenever it is drawn anew."""
    boxes = []

    def seen():
        boxes.append(page.locator("image.tg-cells").first.bounding_box())
        return boxes[-1] is not None

    assert wait_for(seen)
    return boxes[-1]


def click_cell(page, horizontal, vertical):
    """Press the mouse on the heatmap, at shares of its width and height from the lower left."""
    box = map_box(page)
    across, up = horizontal * box["width"], (1 - vertical) * box["height"]
    cells = page.locator("image.tg-cells").first
    cells.click(position={"x": across, "y": up})  # waits until the map stands still


def schedule_shown(page, expected):
    """Wait until the rollout of a schedule is on screen; the verdict's text."""
    wait_for_text(page, ".tg-verdict", expected)
    text = page.locator(".tg-verdict").inner_text()
    assert ("Satisfied" in text) != ("Violated" in text)
    assert "robustness" in text
    return text


def test_from_a_formula_to_rollouts(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach(φ₀, t2)")
    wait_for_node(page, "/scene/region0")

    choose_task(page, "linear-07")
    wait_for_text(page, ".tg-tree", "Reach(A2, t2)")
    page.wait_for_function("!document.querySelector('.tg-tree').textContent.includes('φ₀')")
    assert page.locator(EDITOR).input_value() == load_task("linear-07").formula

    train = page.get_by_role("button", name="Train", exact=True)
    page.locator(EDITOR).fill(WRONG)
    wait_for_text(page, ".tg-error", "unknown name 'A7'")
    assert page.locator(".tg-error pre").text_content() == f"{WRONG}\n{' ' * 25}^"
    page.wait_for_function("b => b.disabled", arg=train.element_handle())
    assert "Reach(A2, t2)" in (page.locator(".tg-tree").text_content() or "")

    page.locator(EDITOR).fill(FORMULA)
    page.wait_for_selector(".tg-error", state="detached")
    wait_for_text(page, ".tg-tree", "Inv(¬B5, [0, 100])")

    train.click()
    page.wait_for_selector("image.tg-cells")
    wait_for_text(page, ".tg-training", "steps / s")
    before = page.locator("image.tg-cells").get_attribute("href")
    page.wait_for_function(
        "before => document.querySelector('image.tg-cells').getAttribute('href') !== before",
        arg=before,
    )

    start = robot_at(page)
    click_cell(page, 0.001, 0.99)
    first = schedule_shown(page, "t1 = 0, t2 = 80")
    wait_for_node(page, "/trail")
    wait_until_robot_leaves(page, start)

    click_cell(page, 0.999, 0.01)
    second = schedule_shown(page, "t1 = 90, t2 = 40")
    assert first != second

    page.get_by_role("button", name="❚❚ Pause").click()
    page.wait_for_selector("button:has-text('Play')")
    standing = robot_at(page)
    page.get_by_role("button", name="Play").click()
    wait_until_robot_leaves(page, standing)

    page.get_by_role("button", name="Stop", exact=True).click()
    wait_for_text(page, ".tg-training", "Stopped")
    assert train.is_visible()
    one, other = studio.session.analyst.answer.recordings[0], studio.session.player.recording
    assert one is other
    assert one.schedule == (90, 40)
