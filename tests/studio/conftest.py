"""Fixtures of the page: servers on free ports, and a browser."""

import re
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from scenes import Scene, load_task
from studio.page.app import Studio
from tests.studio.waiting import PATIENCE

RESULTS = Path("test-results")
MOST_PATIENCE = 240_000
"""After how long a browser is not waited for any more [ms]: as long as a busy machine needs."""
BROWSER_FLAGS = (
    "--no-sandbox --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader "
    "--ignore-gpu-blocklist --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync"
).split()

EVIL = "<img src=x onerror=alert(1)>"
"""A region's name that a careless page would run."""


@pytest.fixture(autouse=True)
def own_state_folder(tmp_path, monkeypatch):
    """Autosaves of the tests are not the user's."""
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


@pytest.fixture
def evil_scene() -> Scene:
    """linear-08 with A1 called `EVIL`."""
    scene = load_task("linear-08")
    regions = tuple(
        replace(region, name=EVIL) if region.name == "A1" else region for region in scene.regions
    )
    formula = f'F_[0:90]("{EVIL}") & F_[40:80](A2) & G_[0:100](!B5) & G_[0:100](!"{EVIL}" | !B1)'
    return replace(scene, name=EVIL, title=EVIL, formula=formula, regions=regions)


def free_port() -> int:
    """A port that was free a moment ago."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextmanager
def running(studio: Studio) -> Iterator[None]:
    """Run the page's loop on a thread; at the end it is closed, and must have ended."""
    loop = threading.Thread(target=studio.run)
    loop.start()
    try:
        yield
    finally:
        studio.close()
        loop.join(timeout=PATIENCE)
    assert not loop.is_alive()


@pytest.fixture(scope="session")
def chromium_path() -> str:
    """An installed Chromium; without one the tests of the page fail, they are not skipped."""
    from tests.tools.browser import find_browser

    path = find_browser()
    assert path, "no Chromium: run `make browser`"
    return path


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    report = yield
    if report.when == "call":
        item.stash[FAILED] = report.failed
    return report


FAILED = pytest.StashKey[bool]()


@pytest.fixture
def page(request, chromium_path):
    """A browser's page at 1440 x 900; a screenshot is kept if the test fails."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium_path, args=BROWSER_FLAGS)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.set_default_timeout(MOST_PATIENCE)
        yield page
        if request.node.stash.get(FAILED, True):
            RESULTS.mkdir(exist_ok=True)
            name = re.sub(r"\W+", "_", request.node.nodeid)
            page.screenshot(path=RESULTS / f"{name}.png")
        browser.close()
