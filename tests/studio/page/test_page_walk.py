"""A mission from a blank page by mouse and keyboard alone: drawn, planned, trained, kept."""

import io
import zipfile
from dataclasses import replace

import jax.numpy as jnp
import numpy as np
import pytest
from jax import export

from core.methods.tgpo.algorithm import make_algorithm
from core.methods.training import TrainingConfig
from scenes import Predicate, Region, blank, parse_scene, robot_of
from scenes.motion import Motion
from studio.page.app import Studio
from studio.runs.bundle import load_bundle
from tests.small import shrink
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import EDITOR, wait_for_node, wait_for_text
from tests.studio.page.test_page_editing import LIST, Pointer, press, scene, wait_until_drawn
from tests.studio.page.test_page_files import download, upload
from tests.studio.page.test_page_shapes import grip
from tests.studio.waiting import wait_for

EPOCHS = 2
ARENA = ((-7.5, 7.5), (-5.0, 5.0))
ROOM = ((-6.0, 1.0), (-3.0, 1.0), (-3.0, 2.0), (-5.0, 2.0), (-5.0, 4.0), (-6.0, 4.0))
FORMULA = "F_[0:90](A1 & slow) & F_[0:90](A2) & F_[0:90](room) & G_[0:90](!wall & !cart)"
PATH = Motion((0, 40), ((0.0, 0.0), (2.0, 0.0)))


@pytest.fixture
def studio(disk_cache, tmp_path):
    """A page on a blank mission, whose trainings are small and short."""

    def make_config(scene, time_limit):
        algorithm = shrink(make_algorithm("studio", "tgpo-star", robot_of(scene)))
        return TrainingConfig(algorithm, seed=scene.seed, epochs=EPOCHS, target=2.0)

    before = replace(blank("unicycle", name="before"), title="Before")
    studio = Studio(before, None, "127.0.0.1", free_port(), make_config)
    with running(studio):
        yield studio


class Walk:
    """What a user does, one after the other."""

    def __init__(self, studio, page):
        self.studio, self.page, self.pointer = studio, page, Pointer(studio, page)

    @property
    def editor(self):
        return self.studio.session.editor

    def field(self, label, number=1):
        """The input after a label."""
        text = f"//*[normalize-space(text())='{label}']"
        return self.page.locator(f"xpath={text}/following::input[{number}]").first

    def type(self, label, value, number=1):
        """Type a value into a field, and leave it."""
        self.field(label, number).fill(str(value))
        self.page.keyboard.press("Tab")

    def begin(self):
        """A new mission for the unicycle, 15 x 10 m."""
        page = self.page
        page.goto(self.studio.url)
        wait_for_text(page, ".tg-tree", "Reach")
        page.locator(".mantine-Notification-closeButton").first.click()
        page.locator("input[value^='choose a robot']").first.click()
        page.get_by_role("option", name="unicycle", exact=True).click()
        wait_for_text(page, ".tg-title", "A new mission for unicycle")
        page.get_by_text("Mission", exact=True).click()
        self.type("Title", "Round the wall")
        wait_for_text(page, ".tg-title", "Round the wall")
        for corner, label in enumerate(("Arena from (m)", "Arena to (m)")):
            for axis, ends in enumerate(ARENA, start=1):
                self.type(label, ends[corner], axis)
        assert wait_for(lambda: scene(self.studio).arena == ARENA)
        page.get_by_text("Mission", exact=True).click()

    def click(self, place):
        """Click on the floor, as the camera sees it now."""
        self.page.mouse.click(*self.pointer._at(*place))

    def take(self, tool):
        press(self.page, tool)
        self.page.wait_for_selector(f"{LIST} button[aria-pressed=true]:has-text('{tool}')")

    def drawn(self, count):
        """Wait until there is another region; it is selected, and its name field shows it."""
        assert wait_for(lambda: len(scene(self.studio).regions) == count)
        wait_for_node(self.page, f"/scene/region{count - 1}")
        name = scene(self.studio).regions[-1].name
        self.page.wait_for_selector(f"input[value='{name}']")
        return name

    def call(self, old, new):
        """Rename the selected region."""
        self.page.locator(f"input[value='{old}']").fill(new)
        assert wait_for(lambda: new in scene(self.studio).region_names)

    def draw_room(self):
        """Click the corners of an L, and the first one again."""
        self.take("polygon")
        for count, corner in enumerate(ROOM, start=1):
            self.click(corner)
            assert wait_for(lambda count=count: len(self.editor.corners) == count)
        self.click(ROOM[0])
        self.call(self.drawn(2), "room")

    def draw_goal(self):
        self.take("circle")
        self.pointer.drag((5.0, -2.0), (5.75, -2.0))
        assert self.drawn(3) == "A2"

    def draw_wall(self):
        """Draw a box and turn it by its handle."""
        self.take("rectangle")
        self.pointer.drag((0.0, -1.0), (3.0, -0.5))
        self.call(self.drawn(4), "wall")
        handle = grip(self.studio, "turn")
        wait_until_drawn(self.page, "/edit/turn0", handle)
        self.pointer.drag(handle, (1.1, 0.2, handle[2]))
        assert wait_for(lambda: scene(self.studio).regions[-1].angle and not self.editor.dragging)

    def draw_cart(self):
        """Draw an obstacle and type its path."""
        self.take("circle")
        self.pointer.drag((4.0, 3.5), (4.4, 3.5))
        self.call(self.drawn(5), "cart")
        self.type("Path", "0: 4, 3.5; 40: 6, 3.5")
        assert wait_for(lambda: scene(self.studio).regions[-1].motion is not None)

    def place_start(self):
        """Make the initial set a point."""
        press(self.page, "start")
        kind = self.page.locator(f"{LIST} >> xpath=following::input[@aria-haspopup='listbox'][1]")
        kind.click()
        self.page.get_by_role("option", name="point", exact=True).click()
        assert wait_for(lambda: scene(self.studio).initial.kind == "point")

    def say(self):
        """Type the predicate and the formula."""
        self.type("Predicates", "slow: v <= 1")
        assert wait_for(lambda: scene(self.studio).predicates)
        self.page.locator(EDITOR).fill(FORMULA)
        wait_for_text(self.page, ".tg-english", "in A1 and slow")


def test_from_a_blank_page_to_a_bundle(studio, page, tmp_path):
    walk, session = Walk(studio, page), studio.session
    walk.begin()
    walk.draw_room()
    walk.draw_goal()
    walk.draw_wall()
    walk.draw_cart()
    walk.place_start()
    walk.say()
    made = scene(studio)
    assert made.regions[1] == Region("room", "polygon", points=ROOM)
    assert made.regions[3].angle % 5 == 0 and made.regions[4].motion == PATH
    assert made.initial == Region("initial", "point", (-2.0, -2.0))
    assert made.predicates == (Predicate("slow", "v <= 1"),)

    def planned():
        recording = session.player.recording
        return recording is not None and recording.task is session.specification.task

    assert wait_for(lambda: session.specification.scene == made and planned())
    wait_for_text(page, ".tg-verdict", "robustness")
    assert session.training.weights is None
    assert session.error == ""

    page.get_by_role("button", name="Train", exact=True).click()
    wait_for_text(page, ".tg-training", "Done")
    assert session.training.epoch == EPOCHS
    assert session.training.scene == made

    page.get_by_role("tab", name="Files").click()
    name, project = download(page, "Save project")
    assert parse_scene(project.decode(), name) == made
    check_bundle(download(page, "Export policy bundle")[1], tmp_path / "bundle", made)

    press(page, "wall")
    press(page, "Delete")
    assert wait_for(lambda: "wall" not in scene(studio).region_names)
    upload(page, "Open project", name, project)
    page.get_by_role("button", name="Go anyway").click()
    page.wait_for_selector(f"{LIST} button:has-text('wall')")
    assert wait_for(lambda: scene(studio) == made)
    assert page.locator(EDITOR).input_value() == FORMULA


def check_bundle(content, folder, made):
    """The bundle has the scene, and its exported program values a schedule."""
    zipfile.ZipFile(io.BytesIO(content)).extractall(folder)
    inside = next(folder.rglob("metadata.json")).parent
    policy = load_bundle(inside)
    assert replace(policy.scene, seed=made.seed) == made
    assert policy.epochs == EPOCHS
    score = export.deserialize(bytearray((inside / "score.stablehlo").read_bytes()))
    state, times = score.in_avals
    value = score.call(jnp.zeros(state.shape, state.dtype), jnp.zeros(times.shape, times.dtype))
    assert np.isfinite(value)
