"""The page in a browser: the demo plays at the start, files are downloaded, errors are survived."""

import pytest

from scenes import load_task
from studio.page import trainer
from studio.page.app import Studio
from tests.studio.conftest import free_port, running
from tests.studio.page.test_page import wait_for_text


@pytest.fixture
def demo(disk_cache, tmp_path):
    """A page as the program opens it: with a plan, for the first time."""
    studio = Studio(load_task("linear-08"), None, "127.0.0.1", free_port(), state=tmp_path)
    with running(studio):
        yield studio


def test_the_demo_plays_and_the_page_outlives_a_failed_training(demo, page, monkeypatch, tmp_path):
    def train(task, config, state=None):
        raise RuntimeError("out of memory <b>")

    monkeypatch.setattr(trainer, "train", train)
    page.goto(demo.url)
    wait_for_text(page, ".tg-tour", "1 of 3")
    page.get_by_role("button", name="Dismiss").click()
    page.wait_for_selector(".tg-tour", state="detached")
    assert (tmp_path / "tour-seen").exists()
    wait_for_text(page, ".tg-verdict", "Satisfied")
    page.wait_for_selector("image.tg-cells")

    page.get_by_role("tab", name="Files").click()
    with page.expect_download() as download:
        page.get_by_role("button", name="CSV").click()
    assert download.value.suggested_filename == "linear-08-rollout.csv"
    assert download.value.path().read_text().startswith("time [s],")

    page.get_by_role("tab", name="Learning").click()
    page.get_by_role("button", name="Train", exact=True).click()
    wait_for_text(page, ".tg-error", "RuntimeError: out of memory <b>")
    page.reload()
    wait_for_text(page, ".tg-error", "RuntimeError: out of memory <b>")
    second = page.context.browser.new_page()
    second.goto(demo.url)
    wait_for_text(second, ".tg-training", "Training failed")
