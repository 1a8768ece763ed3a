"""How quick the page is while training runs, and what the page costs the training.

    python -m tests.tools.page_latency [ROUNDS]

Start, twice: from the start of the process until the server answers, the page is painted and the
demo rollout plays. Speed: ROUNDS (3) windows each of training without a page, with a page that
nobody looks at, and with a browser on it, in turns, so that drift of the machine cancels. Answers:
from an action until its effect is in the browser's document and, apart, until the next frame
(which a browser without a graphics card paints late); and the share of the server alone.
"""

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from core.compilation import use_disk_cache
from core.methods.tgpo.algorithm import make_algorithm
from core.methods.training import TrainingConfig, train
from scenes import Scene, load_task, robot_of
from studio.page.app import Studio
from studio.page.session import DEBOUNCE, Session
from studio.page.trainer import Phase
from studio.runs.tasks import build_task
from tests.studio.conftest import BROWSER_FLAGS, free_port
from tests.studio.waiting import wait_for
from tests.tools.browser import find_browser

TASK = "linear-08"
WINDOW = 6.0
"""Length of one window of training [s]."""
ACTIONS, CLICKS = 20, 12
PATIENCE = 60.0
"""Longest wait for anything [s]."""
WATCH = """([act, argument, selector]) => new Promise((resolve, reject) => {
    const read = () => [...document.querySelectorAll(selector)]
        .map((element) => element.textContent + (element.value ?? "") +
            (element.getAttribute("aria-valuenow") ?? "")).join("|");
    const before = read(), began = performance.now();
    const timer = setInterval(() => {
        if (performance.now() - began > 10000) { clearInterval(timer); resolve(null); }
        if (read() === before) return;
        clearInterval(timer);
        const seen = performance.now() - began;
        requestAnimationFrame(() => resolve([seen, performance.now() - began]));
    }, 2);
    const element = document.querySelectorAll(argument.on)[argument.index ?? 0];
    if (!element) { clearInterval(timer); reject(new Error("nothing is " + argument.on)); return; }
    if (act === "press") element.click();
    if (act === "type") {
        const proto = Object.getPrototypeOf(element);
        Object.getOwnPropertyDescriptor(proto, "value").set.call(element, argument.text);
        element.dispatchEvent(new Event("input", {bubbles: true}));
    }
})"""
"""Milliseconds from an act until the texts of a selector change, and to the next frame; or null."""

Answers = list[list[float] | None]


def main(rounds: int) -> None:
    """Measure and print."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_browser(), args=BROWSER_FLAGS)
        for _ in range(2):  # the second finds compiled what the first may have had to compile
            _start(browser)
        use_disk_cache()
        with _served() as studio:
            session = studio.session
            session.post(session.train)
            _wait(lambda: session.training.epoch >= 2)
            _speeds(studio, browser, rounds)
            _answers(studio, _opened(browser, studio.url))
        browser.close()


def _start(browser: Browser) -> None:
    """The program in a process of its own, with an empty state folder."""
    port = free_port()
    command = [sys.executable, "-m", "studio", "--task", TASK, "--port", str(port), "--no-browser"]
    with tempfile.TemporaryDirectory() as state:
        began = time.monotonic()
        environment = {**os.environ, "XDG_STATE_HOME": state}
        process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL)
        try:
            url = f"http://127.0.0.1:{port}"
            _wait(lambda: _answers_http(url))
            _print_start("server answers", began)
            page = _opened(browser, url)
            _print_start("page painted", began)
            page.wait_for_selector(".tg-verdict")
            page.wait_for_function(
                "document.querySelector('.tg-transport')?.textContent.includes('Pause')"
            )
            _print_start("demo rollout plays (wish: <= 5 s)", began)
            page.close()
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(30)


def _answers_http(url: str) -> bool:
    try:
        with urllib.request.urlopen(url, timeout=1):
            return True
    except OSError:
        return False


@contextmanager
def _served() -> Iterator[Studio]:
    studio = Studio(load_task(TASK), None, "127.0.0.1", free_port(), _endless)
    loop = threading.Thread(target=studio.run)
    loop.start()
    try:
        yield studio
    finally:
        studio.close()
        loop.join(10)


def _endless(scene: Scene, _: float = 0.0) -> TrainingConfig:
    algorithm = make_algorithm("studio", "tgpo-star", robot_of(scene))
    return TrainingConfig(algorithm, seed=scene.seed, epochs=100_000, target=2.0)


def _opened(browser: Browser, url: str) -> Page:
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.set_default_timeout(1000 * PATIENCE)
    page.goto(url)
    page.wait_for_selector(".tg-tree")
    return page


def _speeds(studio: Studio, browser: Browser, rounds: int) -> None:
    """Windows in turns; while the training without a page runs, the page's loop stands still."""
    session = studio.session
    alone = train(build_task(load_task(TASK)), _endless(load_task(TASK)))
    next(alone)
    next(alone)
    speeds = np.zeros((rounds, 3))
    for window in speeds:
        _hold(session)
        go = threading.Event()
        session.post(partial(_stand_still, go))
        window[0] = _speed(lambda: next(alone).env_steps)
        go.set()
        session.post(session.trainer.proceed)
        window[1] = _speed(lambda: _next_epoch(session))
        page = _opened(browser, studio.url)
        window[2] = _speed(lambda: _next_epoch(session))
        page.close()
    names = ("headless", "page, no client (wish: >= -10 %)", "page, one client")
    for name, speed, per_round in zip(names, speeds.mean(0), speeds.T, strict=True):
        change = 100 * (speed / speeds[:, 0].mean() - 1)
        each = " ".join(f"{value:,.0f}" for value in per_round)
        _print(name, f"{speed:8,.0f} steps/s {change:+6.1f} %  (windows: {each})")


def _hold(session: Session) -> None:
    session.trainer.pause()
    _wait(lambda: session.training.phase is Phase.PAUSED)


def _stand_still(go: threading.Event) -> None:
    go.wait(PATIENCE)


def _speed(steps_at_next_epoch: Callable[[], int]) -> float:
    """Environment steps a second between two epochs, evaluations included."""
    steps, began = steps_at_next_epoch(), time.monotonic()
    while True:
        more, now = steps_at_next_epoch(), time.monotonic()
        if now - began >= WINDOW:
            return (more - steps) / (now - began)


def _next_epoch(session: Session) -> int:
    epoch = session.training.epoch
    failed = Phase.FAILED
    _wait(lambda: session.training.epoch > epoch or session.training.phase is failed)
    if session.training.phase is failed:
        raise RuntimeError(session.training.error)
    return session.training.env_steps


def _answers(studio: Studio, page: Page) -> None:
    """Times of actions while the training runs."""
    _print_times("server's share: tick and draw", _ticks(studio))
    page.wait_for_selector("image.tg-cells", state="attached")

    def act(kind: str, argument: dict, selector: str) -> list[float] | None:
        return page.evaluate(WATCH, [kind, argument, selector])

    _print_times(
        "button: a tool for drawing",
        [
            act("press", {"on": ".tg-regions button", "index": 1 - i % 2}, ".tg-regions .tg-dim")
            for i in range(ACTIONS)
        ],
    )
    formula = load_task(TASK).formula
    typed = [
        act(
            "type",
            {"on": "textarea", "text": formula + " &" * (1 - i % 2)},
            ".tg-mono[style*='12px']",
        )
        for i in range(ACTIONS)
    ]
    debounce = 1000 * DEBOUNCE
    without = [time and [part - debounce for part in time] for time in typed]
    _print_times("typing to verdict, less the pause", without)
    _print_times("cell to its rollout (wish: <= 300)", _cells(studio, page))
    session = studio.session
    session.post(lambda: session.player.toggle() if session.player.playing else None)
    page.wait_for_function("document.querySelector('.tg-transport')?.textContent.includes('Play')")
    steps = [
        act("press", {"on": ".tg-transport button", "index": (1, 3)[i % 2]}, "[role=slider]")
        for i in range(ACTIONS)
    ]
    _print_times("step of the rollout to the slider", steps)


def _cells(studio: Studio, page: Page) -> Answers:
    """From a press of the mouse on a cell until the page plays its rollout."""
    times: Answers = []
    for i in range(CLICKS):
        box = None
        while box is None:  # the map is drawn anew now and then
            box = page.locator("image.tg-cells").first.bounding_box()
        shown, began = studio.session.player.recording, time.monotonic()
        page.mouse.click(box["x"] + (0.3 + 0.02 * i) * box["width"], box["y"] + 0.3 * box["height"])
        _wait(lambda shown=shown: studio.session.player.recording is not shown)
        times.append([1000 * (time.monotonic() - began)] * 2)
    return times


def _ticks(studio: Studio) -> Answers:
    """From a posted change until the loop has applied and drawn it."""
    times: Answers = []
    for _ in range(ACTIONS):
        applied, drawn, began = threading.Event(), threading.Event(), time.monotonic()
        # The first change of the tick after the one that applied ours comes after its drawing.
        studio.session.post(applied.set)
        applied.wait(PATIENCE)
        studio.session.post(drawn.set)
        drawn.wait(PATIENCE)
        times.append([1000 * (time.monotonic() - began)] * 2)
    return times


def _wait(condition: Callable[[], bool]) -> None:
    if not wait_for(condition, PATIENCE):
        raise TimeoutError(f"nothing within {PATIENCE:g} s")


def _print(what: str, text: str) -> None:
    print(f"{what:36} {text}   [load {os.getloadavg()[0]:.1f}]", flush=True)


def _print_start(what: str, began: float) -> None:
    _print(what, f"{time.monotonic() - began:6.2f} s")


def _print_times(what: str, answers: Answers) -> None:
    times = np.array([answer for answer in answers if answer is not None]).reshape(-1, 2)
    if times.size == 0:
        _print(what, f"no answer to any of {len(answers)}")
        return
    (seen, painted), (late, late_painted) = np.percentile(times, [50, 95], axis=0)
    _print(
        what,
        f"p50 {seen:5.0f}  p95 {late:5.0f} ms; painted p50 {painted:5.0f}  "
        f"p95 {late_painted:5.0f} ms  ({len(times)} of {len(answers)} answered)",
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 3)
