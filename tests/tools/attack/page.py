"""The whole page: killed at random moments while it saves, and used for minutes."""

import random
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from studio.page.files.projects import SESSIONS, recoverable
from tests.tools.attack.client import Tab, loads
from tests.tools.attack.messages import judged_in
from tests.tools.attack.serving import Served
from tests.tools.attack.table import Row, failures

SAVED_WITHIN = 4.0
"""Age of an edit that a kill must not lose: the autosave's period of 2 s, a pause in typing of
0.35 s, and what a busy machine takes [s]."""
FLAT = 60.0
"""Growth from the third quarter of the use to the last that counts as flat [MB]."""
TASKS = ("linear-08", "unicycle-08", "linear-03", "linear-08")


def attack(count: int, seconds: float) -> list[Row]:
    """A kill for every 20 of `count`, in at most half of the time; use for the other half."""
    return [kills(max(2, count // 20), seconds / 2), use(seconds / 2)]


def kills(count: int, seconds: float) -> Row:
    """Start a page, edit, kill it, and read what it left."""
    chance, deadline = random.Random(0), time.monotonic() + seconds
    lost = killed = tracebacks = 0
    slowest, known = 0.0, set[str]()
    with tempfile.TemporaryDirectory() as folder:
        state = Path(folder)
        while killed < count and (killed < 1 or time.monotonic() < deadline):
            began = time.monotonic()
            page = Served(state, "--task", "linear-08")
            slowest = max(slowest, time.monotonic() - began)
            judged_in(page.port)  # what compiles at the start has compiled
            edits = _edit_until(page, time.monotonic() + chance.uniform(4.5, 9.0))
            now = time.monotonic()
            page.kill()
            killed, tracebacks = killed + 1, tracebacks + page.tracebacks
            wanted = max((n for n, at in edits.items() if now - at > SAVED_WITHIN), default=0)
            left = {each.session: each for each in recoverable(state / "tgpo-studio" / "autosave")}
            saved = [_number(left[name].scene.formula) for name in set(left) - known]
            if max(saved, default=0) < wanted or not known <= set(left):
                lost += 1
                ages = {number: round(now - at, 1) for number, at in edits.items()}
                print(f"page: saved {saved} of edits {ages}; {known - set(left)}", file=sys.stderr)
            known = set(sorted(left)[-SESSIONS // 2 :])  # a page keeps the last few
    wrong = {"edits or earlier sessions lost": lost, "tracebacks": tracebacks}
    bad = failures("page", "kill -9 while it saves", wrong)
    return Row("page", "kill -9 while it saves", killed, 0, bad, slowest, 0.0)


def _edit_until(page: Served, end: float) -> dict[int, float]:
    """Change the formula again and again; which edits were made, and when."""
    edits: dict[int, float] = {}
    with Tab(page.port) as tab:
        tab.loaded.wait(20)
        field = tab.labelled("Formula")["uuid"]
        while time.monotonic() < end:
            number = len(edits) + 1
            tab.set(field, f"F_[0:{number}](A1)")
            edits[number] = time.monotonic()
            time.sleep(0.6)
    return edits


def _number(formula: str) -> int:
    return int(formula.removeprefix("F_[0:").partition("]")[0]) if formula.endswith("](A1)") else 0


def use(seconds: float) -> Row:
    """Change tasks, edit, train, save and look, in tabs that come and go."""
    memory: list[float] = []
    slowest, actions, began = 0.0, 0, time.monotonic()
    with tempfile.TemporaryDirectory() as folder, Served(Path(folder), "--task", TASKS[0]) as page:
        judged_in(page.port)
        chance, first = random.Random(1), page.memory
        while time.monotonic() - began < seconds:
            with Tab(page.port) as tab:
                tab.loaded.wait(20)
                actions += _round(chance, tab, TASKS[len(memory) % len(TASKS)])
                slowest = max(slowest, tab.ping())
            memory.append(page.memory)
        new_page = loads(page.port)
        wrong = {
            "a new page does not load": not new_page,
            "tracebacks": page.tracebacks,
            "the process is dead": not page.alive,
            "memory is not flat": _late_growth(memory) > FLAT,
        }
    what = f"{seconds / 60:.1f} min of use"
    bad = failures("page", what, wrong)
    print(f"page: memory of each round [MB], from {first:.0f}: {[round(m) for m in memory]}")
    return Row("page", what, actions, 0, bad, slowest, _late_growth(memory))


def _late_growth(memory: list[float]) -> float:
    """From the third quarter to the last [MB]; 0 if there are too few rounds to tell."""
    quarter = len(memory) // 4
    if quarter < 2:
        return 0.0
    return statistics.median(memory[-quarter:]) - statistics.median(memory[-2 * quarter : -quarter])


def _round(chance: random.Random, tab: Tab, task: str) -> int:
    """One task: open it, edit, train for a second, roll out, export; how many actions."""
    menu, field = tab.labelled("Task")["uuid"], tab.labelled("Formula")["uuid"]
    answer = next(c for c in tab.controls() if "Go anyway" in c["props"].get("options", ()))
    steps: list[tuple[str, Any, float]] = [
        (menu, task, 0.3),
        (answer["uuid"], "Go anyway", 2.0),
        (tab.labelled("Time limit")["uuid"], 1.0, 0.1),
    ]
    for _ in range(5):
        edit = f"F_[0:{chance.randint(10, 60)}](A1) & G_[0:100](!B1)"
        steps.append((field, edit, chance.uniform(0.1, 0.6)))
    steps.append((tab.labelled("Train", "Train next", "Queued")["uuid"], True, 8.0))
    for label in ("Save project", "Export policy bundle"):
        steps.append((tab.labelled(label)["uuid"], True, 0.5))
    for uuid, value, pause in steps:
        tab.set(uuid, value)
        time.sleep(pause)
    return len(steps)
