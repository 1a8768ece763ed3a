"""How quick the page is while training runs, and what the page costs the training.

    python -m tests.tools.page_latency [SECONDS]

Measures for SECONDS (30) each: the training without a page, with a page that nobody looks at,
with a browser on it; and in the browser, from an event until its effect is in the page,
the answer to a click on a button and the rollout of a clicked cell.
"""

import sys
import threading
import time
from collections.abc import Callable

import numpy as np
from playwright.sync_api import Page, sync_playwright

from core.algorithm import make_algorithm
from core.programs import use_disk_cache
from core.training import TrainingConfig, train
from scenes import Scene, load_task
from studio.app import Studio
from studio.tasks import build_task
from studio.worker import Stage
from tests.studio.conftest import BROWSER_FLAGS, free_port
from tests.tools.browser import find_browser

TASK = "linear-08"
CALLBACKS, CLICKS = 100, 20
WATCH = """([selector, x, y]) => new Promise((resolve, reject) => {
    const target = document.elementFromPoint(x, y), began = performance.now();
    const before = document.querySelector(selector)?.textContent;
    const observer = new MutationObserver(() => {
        if (document.querySelector(selector)?.textContent === before) return;
        observer.disconnect();
        requestAnimationFrame(() => resolve(performance.now() - began));
    });
    observer.observe(document.body, {subtree: true, childList: true, characterData: true});
    const at = {clientX: x, clientY: y, bubbles: true};
    for (const kind of ["pointerdown", "mousedown", "pointerup", "mouseup", "click"])
        target.dispatchEvent(new MouseEvent(kind, at));
    setTimeout(() => { observer.disconnect(); reject(new Error("no answer in 10 s")); }, 10000);
})"""
"""Milliseconds from a click at (x, y) until the text of a selector is another one and painted."""


def main(seconds: float) -> None:
    """Measure and print."""
    use_disk_cache()
    alone = _headless(seconds)
    print(f"headless                      {alone:10,.0f} steps/s", flush=True)
    began = time.monotonic()
    studio = Studio(load_task(TASK), None, "127.0.0.1", free_port(), _endless)
    loop = threading.Thread(target=studio.run)
    loop.start()
    try:
        print(f"server up after               {time.monotonic() - began:10.2f} s", flush=True)
        session = studio.session
        session.post(session.train)
        _wait(lambda: session.training.epoch >= 2)
        _print_speed("page, no client", _speed(studio, seconds), alone)
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=find_browser(), args=BROWSER_FLAGS)
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            _start(page, studio)
            _print_speed("page, one client", _speed(studio, seconds), alone)
            _print_times("callback", _callbacks(page), "p95 <= 100")
            _print_times("click to rollout", _clicks(page), "<= 300")
            browser.close()
    finally:
        studio.close()
        loop.join(10)


def _endless(scene: Scene, _: float = 0.0) -> TrainingConfig:
    algorithm = make_algorithm("studio", "tgpo-star", scene.robot)
    return TrainingConfig(algorithm, seed=scene.seed, epochs=100_000, target=2.0)


def _headless(seconds: float) -> float:
    """Environment steps a second, evaluations included, from the second epoch on."""
    scene = load_task(TASK)
    first = None
    for epoch in train(build_task(scene), _endless(scene)):
        now = time.monotonic()
        if first is None:
            first = now, epoch.env_steps
        elif now - first[0] >= seconds:
            return (epoch.env_steps - first[1]) / (now - first[0])
    raise AssertionError("the training has no end of its own")


def _speed(studio: Studio, seconds: float) -> float:
    """Environment steps a second between two epochs of the page's training."""
    began, steps = _next_epoch(studio)
    while True:
        now, more = _next_epoch(studio)
        if now - began >= seconds:
            return (more - steps) / (now - began)


def _next_epoch(studio: Studio) -> tuple[float, int]:
    """When the next epoch ends, and the steps until then."""
    session = studio.session
    epoch = session.training.epoch
    _wait(lambda: session.training.epoch > epoch or session.training.stage is Stage.FAILED)
    if session.training.stage is Stage.FAILED:
        raise RuntimeError(session.training.error)
    return time.monotonic(), session.training.env_steps


def _start(page: Page, studio: Studio) -> None:
    """Open the page; print when it is painted and when the map is there."""
    page.set_default_timeout(120_000)
    began = time.monotonic()
    page.goto(studio.url)
    for what, selector in (("tree", ".tg-tree"), ("map", "image.tg-cells")):
        page.wait_for_selector(selector)
        print(f"{what:5} painted while training  {time.monotonic() - began:10.2f} s", flush=True)
    for notice in page.locator(".mantine-Notification-closeButton").all():
        notice.click()


def _callbacks(page: Page) -> np.ndarray:
    """Times of presses of the tools for drawing [ms]."""
    times = []
    for count in range(CALLBACKS):
        name = ("rectangle", "select")[count % 2]
        box = page.locator(".tg-regions button", has_text=name).first.bounding_box()
        assert box is not None
        at = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        times.append(page.evaluate(WATCH, [".tg-regions .tg-dim", *at]))
    return np.array(times)


def _clicks(page: Page) -> np.ndarray:
    """Times from a press on the map until its rollout's verdict is on screen [ms]."""
    times = []
    for count in range(CLICKS):
        box = page.locator("image.tg-cells").bounding_box()
        assert box is not None
        at = (
            box["x"] + (count + 0.5) / CLICKS * box["width"],
            box["y"] + (0.3, 0.7)[count % 2] * box["height"],
        )
        times.append(page.evaluate(WATCH, [".tg-verdict", *at]))
    return np.array(times)


def _wait(condition: Callable[[], bool]) -> None:
    while not condition():
        time.sleep(0.002)


def _print_speed(what: str, speed: float, alone: float) -> None:
    print(f"{what:29} {speed:10,.0f} steps/s  {100 * (speed / alone - 1):+.1f} %", flush=True)


def _print_times(what: str, times: np.ndarray, wish: str) -> None:
    p50, p95 = np.percentile(times, [50, 95])
    print(f"{what:29} p50 {p50:6.0f} ms  p95 {p95:6.0f} ms  (wish: {wish} ms)", flush=True)


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 30.0)
