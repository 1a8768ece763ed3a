"""Editing in a browser: draw, type, undo, rename, move, and what an edit makes stale."""

import numpy as np
import pytest
from viser.transforms import SO3

from core.methods.training import TrainingConfig
from scenes import load_task
from studio.page import analyst, trainer
from studio.page.app import Studio
from tests.small import scripted_epoch
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import EDITOR, wait_for_node, wait_for_text
from tests.studio.waiting import wait_for

FORMULA = "F_[0:90](A4) & F_[40:80](A5)"
LIST = ".tg-regions"


@pytest.fixture
def studio(monkeypatch, small_algorithm):
    """A page whose training ends after an epoch without learning anything."""
    monkeypatch.setattr(trainer, "train", lambda *_, **__: iter([scripted_epoch()]))
    monkeypatch.setattr(analyst.Analyst, "observe", lambda *_: None)
    config = TrainingConfig(small_algorithm)
    studio = Studio(load_task("linear-08"), None, "127.0.0.1", free_port(), lambda *_, **__: config)
    with running(studio):
        yield studio


class Pointer:
    """The mouse over points of the floor, and the document that it edits."""

    def __init__(self, studio, page):
        self._studio, self._page = studio, page

    def drag(self, start, end, key=None):
        """Press at one point, release at another; both in [m]."""
        if key:
            self._page.keyboard.down(key)
        x, y = self._at(*start)
        self._page.mouse.move(x, y)
        self._page.mouse.down()
        self._page.mouse.move(x + 8, y + 8)
        self._page.mouse.move(*self._at(*end), steps=6)
        self._page.mouse.up()
        if key:
            self._page.keyboard.up(key)

    def _at(self, x, y, z=0.0):
        camera = next(iter(self._studio._server.get_clients().values())).camera
        ray = SO3(np.asarray(camera.wxyz)).as_matrix().T @ ((x, y, z) - camera.position)
        left, top, width, height = self._page.evaluate(
            """() => {
                const box = document.querySelector('canvas').getBoundingClientRect();
                return [box.x, box.y, box.width, box.height];
            }"""
        )
        focal = height / 2 / np.tan(camera.fov / 2)
        at = (
            left + width / 2 + focal * ray[0] / ray[2],
            top + height / 2 + focal * ray[1] / ray[2],
        )
        return float(at[0]), float(at[1])


def shown_at(page, node):
    return page.evaluate("n => window.__viserMutable.nodePoseData[n]?.position ?? null", node)


def wait_until_drawn(page, node, place):
    """Until a node stands on screen at a place [3], where the pointer meets it."""
    page.wait_for_function(
        """([node, place]) => {
            const drawn = window.__viserMutable.nodeRefFromName[node];
            const at = drawn?.matrix.elements.slice(12, 15) ?? [Infinity];
            return Math.hypot(...at.map((x, i) => x - place[i])) < 1e-3;
        }""",
        arg=[node, [float(value) for value in place]],
    )


def press(page, text):
    page.locator(f"{LIST} button", has_text=text).first.click()


def begin_anew(page, robot, title):
    """Open a new mission, whatever is lost, and give it a title."""
    page.locator("input[value^='choose a robot']").first.click()
    page.get_by_role("option", name=robot, exact=True).click()
    page.get_by_role("button", name="Go anyway").click()
    page.get_by_text("Mission", exact=True).click()
    page.locator(f"input[value='A new mission for {robot}']").fill(title)
    wait_for_text(page, ".tg-title", title)


def scene(studio):
    return studio.session.document.scene


def test_draw_type_undo_rename_move_and_stale(studio, page):
    page.goto(studio.url)
    wait_for_text(page, ".tg-tree", "Reach")
    wait_for_node(page, "/scene/region7")
    wait_for_node(page, "/floor")
    pointer = Pointer(studio, page)

    press(page, "circle")
    page.wait_for_selector(f"{LIST} button[aria-pressed=true]:has-text('circle')")
    pointer.drag((-2.5, 0.5), (-2.0, 0.5))
    wait_for_node(page, "/scene/region8")
    pointer.drag((-1.5, -3.5), (-0.5, -2.5), key="Shift")
    wait_for_node(page, "/scene/region9")
    wait_for_text(page, LIST, "A5")
    circle, rectangle = scene(studio).regions[-2:]
    assert (circle.kind, circle.center, circle.size) == ("circle", (-2.5, 0.5), (0.5,))
    assert (rectangle.kind, rectangle.center) == ("rectangle", (-1.0, -3.0))

    page.locator(EDITOR).fill(FORMULA)
    wait_for_text(page, ".tg-tree", "Reach(A5, t2)")

    wait_for_text(page, ".tg-english", "Between 8 s and 16 s be in A5.")

    press(page, "↶")
    page.wait_for_function("() => !document.querySelector('.tg-tree').textContent.includes('A5')")
    assert page.locator(EDITOR).input_value() == load_task("linear-08").formula
    page.locator("canvas").first.focus()
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Control+Shift+Z")
    wait_for_text(page, ".tg-tree", "Reach(A5, t2)")
    assert page.locator(EDITOR).input_value() == FORMULA

    page.locator("input[value=A5]").fill("Home")
    wait_for_text(page, ".tg-tree", "Reach(Home, t2)")
    page.wait_for_function(
        "selector => document.querySelector(selector).value.includes('(Home)')", arg=EDITOR
    )
    assert studio.session.document.region("Home") == scene(studio).regions[-1]
    wait_for_text(page, ".tg-english", "Between 8 s and 16 s be in Home.")

    page.get_by_role("button", name="Train", exact=True).click()
    wait_for_text(page, ".tg-training", "Done")
    assert not studio.session.stale
    assert page.get_by_text("Stale:").count() == 0

    before = shown_at(page, "/scene/region8")
    pointer.drag((-2.6, 0.5), (-3.1, -0.5))
    assert wait_for(lambda: studio.session.document.region("A4").center == (-3.0, -0.5))
    page.wait_for_function(
        """([node, x]) => Math.abs(
            window.__viserMutable.nodePoseData[node].position[0] - x) > 0.4""",
        arg=["/scene/region8", before[0]],
    )
    page.wait_for_selector("text=Stale: region A4 has changed since training")

    page.evaluate("document.activeElement.blur()")
    page.keyboard.press("Control+Z")
    page.wait_for_selector("text=Stale:", state="detached")
    assert studio.session.document.region("A4").center == (-2.5, 0.5)

    begin_anew(page, "linear", "Round the shelf")
    assert scene(studio).region_names == ("A1",)
