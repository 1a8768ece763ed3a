"""How often plans and maps follow a region that is dragged, on a page that trains nothing.

    python -m tests.tools.page_dragging [TASK ...]

The mouse takes a region and moves it round a small circle for SECONDS, in a browser that plays the
rollouts meanwhile. Counted are the edits that the browser sent, and the plans and maps that came
while the region was held; an answer's age is the time since the edit that it answers was made. A
browser without a graphics card keeps the processor busy with painting and sends few edits, so the
same is done once more with an edit every `FRAME` and a tab that paints nothing: what the server
gives a browser on another machine.
"""

import sys
import threading
import time
from collections.abc import Callable
from functools import partial
from typing import NamedTuple
from urllib.parse import urlsplit

import numpy as np
from playwright.sync_api import Page, sync_playwright

from core.compilation import use_disk_cache
from scenes import load_task, workspace_of
from studio.page.analyst import STARTS
from studio.page.app import FRAME, Studio
from studio.page.session import Session
from tests.studio.conftest import BROWSER_FLAGS, free_port, running
from tests.studio.page.test_page_editing import Pointer
from tests.studio.waiting import wait_for
from tests.tools.attack.client import Tab
from tests.tools.browser import find_browser

TASKS = ("linear-08", "unicycle-08", "panda-08", "quadrotor-08", "ant-08")
SECONDS = 8.0
"""How long the region is held."""
WARMING = 2.0
"""How long before that: the first edit compiles what others find compiled [s]."""
PIXELS, SHARE = 60.0, 0.06
"""Radius of the circle, of the mouse and, as a share of the arena's width, of a region's centre."""
TURN = 3.0
"""Time of one round [s]."""
PATIENCE = 120.0
HEAD = f"{'':14}{'':10}{'edits/s':>9}{'plans/s':>9}{'maps/s':>9}{'age p50':>9}{'p95 [s]':>9}"


class _Seen(NamedTuple):
    edits: list[float]
    plans: list[float]
    maps: list[float]
    """When they came [s]."""
    ages: list[float]
    """Of the plans [s]."""


def main(tasks: list[str]) -> None:
    """Measure and print, task by task."""
    use_disk_cache()
    print(HEAD, flush=True)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_browser(), args=BROWSER_FLAGS)
        for name in tasks:
            with running(studio := _studio(name)):
                page = browser.new_page(viewport={"width": 1440, "height": 900})
                page.goto(studio.url)
                page.wait_for_selector("image.tg-cells", state="attached", timeout=60_000)
                _settle(studio.session)
                x, y = _taken(studio, page)
                _print(name, "by mouse", studio, partial(_move_mouse, page, x, y))
                page.mouse.up()
                page.close()
            with running(studio := _studio(name)), Tab(urlsplit(studio.url).port or 0) as tab:
                tab.loaded.wait(PATIENCE)
                _settle(studio.session)
                _print(name, "server", studio, _mover(studio.session))
        browser.close()


def _studio(name: str) -> Studio:
    return Studio(load_task(name), None, "127.0.0.1", free_port())


def _settle(session: Session) -> None:
    """Wait until the page has answered all that it asks by itself."""

    def counted() -> bool:
        share = session.analyst.share
        return share is not None and share.starts >= STARTS

    if not wait_for(counted):
        raise TimeoutError("the page has not tried its starts")
    time.sleep(1.0)


def _taken(studio: Studio, page: Page) -> tuple[float, float]:
    """Press the mouse on the first region that it takes; returns where [pixels]."""
    session, pointer = studio.session, Pointer(studio, page)
    for region in session.document.scene.regions:
        center = np.zeros(3)
        center[: len(region.center)] = region.center
        x, y = pointer._at(*center)
        page.mouse.move(x, y)
        page.mouse.down()
        page.mouse.move(x + 6, y, steps=3)
        page.wait_for_timeout(400)
        if session.editor.dragging:
            return x, y
        page.mouse.up()
    raise RuntimeError(f"{session.document.scene.name}: the mouse takes no region")


def _move_mouse(page: Page, x: float, y: float, right: float, up: float) -> None:
    page.mouse.move(x + PIXELS * right, y - PIXELS * up)


def _mover(session: Session) -> Callable[[float, float], None]:
    """Moves the first region as a drag does."""
    scene, zero = session.document.scene, (0.0, 0.0, 0.0)
    name, (low, high) = scene.regions[0].name, workspace_of(scene).arena[0]
    radius = SHARE * (high - low)
    session.post(partial(session.editor.move, name, "start", zero, zero))

    def move(right: float, up: float) -> None:
        to = (radius * right, radius * up, 0.0)
        session.post(partial(session.editor.move, name, "update", zero, to))

    return move


def _print(name: str, by: str, studio: Studio, move: Callable[[float, float], None]) -> None:
    _drag(studio, move, WARMING)
    seen = _drag(studio, move, SECONDS)
    p50, p95 = np.percentile(seen.ages or [np.nan], [50, 95])
    rates = "".join(f"{len(times) / SECONDS:9.1f}" for times in seen[:3])
    print(f"{name:14}{by:10}{rates}{p50:9.2f}{p95:9.2f}", flush=True)


def _drag(studio: Studio, move: Callable[[float, float], None], seconds: float) -> _Seen:
    """Move a region round a circle, and count what comes of it."""
    over, seen = threading.Event(), _Seen([], [], [], [])
    # On a thread: the browser lets a mouse wait while it paints.
    counter = threading.Thread(target=_count, args=(studio.session, seen, over))
    counter.start()
    began = time.monotonic()
    while (now := time.monotonic()) < began + seconds:
        angle = 2 * np.pi * (now - began) / TURN
        move(np.sin(angle), 1 - np.cos(angle))
        time.sleep(max(0.0, now + FRAME - time.monotonic()))
    over.set()
    counter.join()
    return seen


def _count(session: Session, seen: _Seen, over: threading.Event) -> None:
    scene, task = session.document.scene, session.specification.task
    answer, picture = session.analyst.answer, session.analyst.picture
    made, judged = [(scene, time.monotonic())], [(task, time.monotonic())]
    while not over.wait(0.002):
        now = time.monotonic()
        if session.document.scene is not scene:
            scene = session.document.scene
            made.append((scene, now))
            seen.edits.append(now)
        if session.specification.task is not task:
            task, of = session.specification.task, session.specification.scene
            judged += [(task, then) for edit, then in made if edit is of]
        if session.analyst.answer is not answer:
            answer = session.analyst.answer
            seen.plans.append(now)
            if answer is not None:
                of = answer.recordings[0].task
                seen.ages.extend(now - then for one, then in judged if one is of)
        if session.analyst.picture is not picture:
            picture = session.analyst.picture
            seen.maps.append(now)


if __name__ == "__main__":
    main(sys.argv[1:] or list(TASKS))
