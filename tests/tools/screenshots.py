"""Pictures of the page for the README, 1440 x 900, written to docs/images.

    python -m tests.tools.screenshots [FOLDER]

Trains on the way; a minute or two.
"""

import io
import sys
import threading
from functools import partial
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

from core.compilation import use_disk_cache
from scenes import load_task
from studio.page.app import Studio
from studio.runs.recording import Recording
from tests.studio.conftest import BROWSER_FLAGS, free_port
from tests.studio.page.test_page_editing import Pointer
from tests.tools.browser import find_browser

FOLDER = Path(__file__).parents[2] / "docs" / "images"
LARGEST = 300_000  # bytes
WAIT = 240_000  # [ms]


def main(folder: Path) -> None:
    """Serve a page, walk through its states and take a picture of each."""
    use_disk_cache()
    folder.mkdir(parents=True, exist_ok=True)
    studio = Studio(load_task("linear-08"), None, "127.0.0.1", free_port())
    loop = threading.Thread(target=studio.run)
    loop.start()
    try:
        with sync_playwright() as playwright:
            executable = find_browser()
            browser = playwright.chromium.launch(executable_path=executable, args=BROWSER_FLAGS)
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            page.set_default_timeout(WAIT)
            _walk(studio, page, folder)
            _moved(studio, page, folder)
            _demos(studio, page, folder)
            browser.close()
    finally:
        studio.close()
        loop.join(10)


def _walk(studio: Studio, page: Page, folder: Path) -> None:
    session = studio.session
    page.goto(studio.url)
    page.wait_for_selector(".tg-verdict")
    page.wait_for_selector("image.tg-cells")
    _dismiss_notices(page)
    _play_until(page, studio, 55)
    _take(page, folder / "studio.png")

    session.settings.from_weights = False  # from the weights it ends before anything is seen
    page.get_by_role("button", name="Train", exact=True).click()
    while session.training.epoch < 7:
        page.wait_for_timeout(50)
    page.wait_for_selector("image.tg-cells")
    _take(page, folder / "training.png")
    page.wait_for_function("document.querySelector('.tg-training').textContent.includes('Done')")
    page.wait_for_selector(".tg-verdict")

    box = page.locator("image.tg-cells").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 0.42 * box["width"], box["y"] + 0.55 * box["height"])
    chosen = session.player.recording
    page.wait_for_function("document.querySelector('.tg-verdict') !== null")
    _play_until(page, studio, 70, unless=chosen)
    _take(page, folder / "clicked.png")


def _moved(studio: Studio, page: Page, folder: Path) -> None:
    """A robot that is dragged away while its rollout plays, and goes on."""
    session = studio.session
    session.post(partial(session.choose_task, "linear-demo"))
    _play_until(page, studio, 12, task="linear-demo")
    session.post(partial(session.player.seek, 12))
    page.wait_for_timeout(500)
    before = session.player.recording
    assert before is not None
    Pointer(studio, page).drag(before.positions[12, :2], (-4.0, 3.0))
    _play_until(page, studio, 34, unless=before)
    _take(page, folder / "moved.png")


def _demos(studio: Studio, page: Page, folder: Path) -> None:
    """The demos of the robots in space and of the ant, at their ends."""
    session = studio.session
    for robot in ("panda", "quadrotor", "ant"):
        session.post(partial(session.choose_task, f"{robot}-demo"))
        while session.specification.scene.name != f"{robot}-demo" or not session.player.recording:
            page.wait_for_timeout(50)
        recording = session.player.recording
        page.wait_for_selector("image.tg-cells")
        _play_until(page, studio, int(0.7 * recording.steps))
        _take(page, folder / f"{robot}.png")


def _play_until(
    page: Page, studio: Studio, step: int, unless: Recording | None = None, task: str = ""
) -> None:
    """Wait until a rollout, another than `unless` and of that task, has come to a step."""
    for _ in range(600):
        player = studio.session.player
        recording = player.recording
        wanted = recording is not None and (not task or recording.task.name == task)
        if wanted and recording is not unless and player.position >= step:
            return
        page.wait_for_timeout(50)


def _dismiss_notices(page: Page) -> None:
    """Close the viewer's notices, such as that of software rendering."""
    # At once, in the page: a notice that goes by itself would let the mouse wait for it.
    page.evaluate(
        "document.querySelectorAll('.mantine-Notification-closeButton').forEach(b => b.click())"
    )


def _take(page: Page, path: Path) -> None:
    """Keep a screenshot without notices, in a palette of 256 colours if it is large."""
    _dismiss_notices(page)
    page.wait_for_timeout(300)
    image = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    image.save(path, optimize=True)
    if path.stat().st_size > LARGEST:
        image.quantize(256, dither=Image.Dither.NONE).save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER)
