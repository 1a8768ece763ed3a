"""The gallery tells of the scenes that are shipped."""

import pytest

from envs import ENVS
from scenes import task_names
from tests.tools.gallery import FOLDER, draw_sheet, looks, shipped, text

LARGEST = 250_000  # bytes


def test_the_page_is_what_the_script_writes():
    """After a change of scenes: `make gallery`."""
    assert (FOLDER / "gallery.md").read_text(encoding="utf-8") == text()


@pytest.mark.parametrize("robot", ENVS)
def test_every_task_has_a_picture(robot):
    scenes = shipped(robot)
    assert {scene.name for scene in scenes} >= set(task_names(robot))
    sheet = draw_sheet(scenes)
    assert [axes.get_title() for axes in sheet.axes if axes.get_title()] == [s.name for s in scenes]
    image = FOLDER / "images" / f"gallery-{robot}.png"
    assert image.stat().st_size < LARGEST


@pytest.mark.parametrize("robot", ENVS)
def test_every_region_is_named_but_for_walls_in_space(robot):
    scenes = shipped(robot)
    for scene, axes in zip(scenes, draw_sheet(scenes).axes, strict=False):
        named = {text.get_text() for text in axes.texts}
        wanted = {look.label for _, look in looks(scene)}
        walls = {f"W{index}" for index in range(1, 7)} if scene.dimension == 3 else set()
        assert named == wanted - walls, scene.name
