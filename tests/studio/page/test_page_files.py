"""The files of the page in a browser: each is downloaded and read, projects and policies return."""

import io
import json
import zipfile

import numpy as np
from PIL import Image

from scenes import load_task, parse_scene
from scenes.scene import format_scene
from tests.studio.page.test_page import wait_for_text
from tests.studio.page.test_page_keep import demo
from tests.studio.waiting import wait_for

__all__ = ["demo"]

UPLOADS = "input[type=file]"


def download(page, button):
    """Name and bytes of what a button sends."""
    with page.expect_download() as sent:
        page.get_by_role("button", name=button, exact=True).click()
    return sent.value.suggested_filename, sent.value.path().read_bytes()


def upload(page, button, name, content):
    with page.expect_file_chooser() as chooser:
        page.get_by_role("button", name=button).click()
    chooser.value.set_files({"name": name, "mimeType": "", "buffer": content})


def test_each_file_can_be_read_and_comes_back(demo, page):
    page.goto(demo.url)
    page.get_by_role("button", name="Dismiss").click()
    wait_for_text(page, ".tg-verdict", "Satisfied")
    page.wait_for_selector("image.tg-cells")
    page.get_by_role("tab", name="Files").click()

    name, project = download(page, "Save project")
    assert parse_scene(project.decode(), name) == load_task("linear-08")
    _, bundle = download(page, "Export policy bundle")
    assert json.loads(zipfile.ZipFile(io.BytesIO(bundle)).read("metadata.json"))["robot"]
    steps = demo.session.player.recording.steps
    _, table = download(page, "CSV")
    assert len(table.decode().splitlines()) == steps + 2
    _, arrays = download(page, "NPZ")
    with np.load(io.BytesIO(arrays)) as read:
        assert read["satisfied"]
    _, recording = download(page, "HTML")
    assert b"__VISER_EMBED_DATA__" in recording
    for button in ("Heatmap", "Tree"):
        _, picture = download(page, button)
        assert Image.open(io.BytesIO(picture)).format == "PNG"

    upload(page, "Open project", "other.stl.toml", format_scene(load_task("linear-07")).encode())
    wait_for_text(page, ".tg-tree", "Reach(A2, t2)")
    assert wait_for(lambda: demo.session.specification.scene == load_task("linear-07"))
    upload(page, "Load a run or bundle", name="kept.zip", content=bundle)
    wait_for_text(page, ".tg-kept", "Loaded kept.zip")
    assert wait_for(lambda: demo.session.document.scene == load_task("linear-08"))
    wait_for_text(page, ".tg-verdict", "Satisfied")

    upload(page, "Open project", "broken.stl.toml", b"robot = [")
    wait_for_text(page, ".tg-error", "Could not open the file")
    assert demo.session.document.scene == load_task("linear-08")
