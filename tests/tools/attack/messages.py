"""Websocket messages, from a tab whose handlers run: of the right form and of wrong ones.

Controls that compile or make files are left out; the part `page` uses them.
"""

import math
import random
import re
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from tests.tools.attack.client import CAMERA, Tab, loads
from tests.tools.attack.serving import Served
from tests.tools.attack.table import Row, failures, hangs

BATCH = 100
SLOW = re.compile("Train|Task|Rollout|Pictures|Export|Save")
"""Labels of controls that compile or make files."""

JUNK = [
    None,
    True,
    0,
    -1,
    1.5,
    1e30,
    -1e30,
    2**64 - 1,
    -(2**63),
    math.nan,
    math.inf,
    "",
    "x" * 9000,
]
JUNK += [[], [1e30] * 3, [math.nan] * 3, [1, 2], ["a"] * 3, [[1]], {}, {"a": 1}, b"", b"\xff" * 99]
JUNK += ["\x00", "🤖" * 500, "<script>", "0 0", "play", "F_[0:9](A1", "A1", "1e999 5", "-1 -1 0"]

Random = random.Random


def attack(count: int, seconds: float) -> list[Row]:
    """On a page of its own."""
    with tempfile.TemporaryDirectory() as folder, Served(Path(folder)) as page:
        return attack_page(page, count, seconds)


def attack_page(page: Served, count: int, seconds: float) -> list[Row]:
    """Each form in turn, with `count` messages altogether."""
    forms = {
        "values that fit": (_fitting, 0.23),
        "other tasks": (_task, 0.02),
        "other values": (_unfitting, 0.25),
        "attributes": (_attribute, 0.1),
        "camera and scene": (_scene, 0.15),
        "mutated": (_mutated, 0.15),
        "bytes": (_bytes, 0.1),
    }
    rows, began = [], time.monotonic()
    judged_in(page.port)  # what compiles at the start has compiled
    for what, (make, share) in forms.items():
        left = max(1.0, seconds - (time.monotonic() - began))
        rows.append(_flood(page, what, make, max(1, int(share * count)), left))
    return rows


def _flood(
    page: Served, what: str, make: Callable[[Random, Tab], Any], count: int, seconds: float
) -> Row:
    """Send messages of one form; afterwards a new page must work, and its formula be judged."""
    chance, before = random.Random(what), (page.memory, page.tracebacks, page.dropped)
    deadline, slowest, sent = time.monotonic() + seconds, 0.0, 0
    with Tab(page.port) as tab:
        loaded = tab.loaded.wait(20)
        while sent < count and time.monotonic() < deadline and not tab.ended.is_set():
            for _ in range(min(BATCH, count - sent)):
                tab.send(make(chance, tab))
                sent += 1
            slowest = max(slowest, tab.ping())
        ended = tab.ended.is_set()
    took = judged_in(page.port)
    wrong = {
        "did not load": not loaded,
        "was cut off": ended,
        "a new page does not load": not loads(page.port),
        "tracebacks": page.tracebacks - before[1],
        "the process is dead": not page.alive,
        **hangs(slowest, took),
    }
    return Row(
        "messages",
        what,
        sent,
        page.dropped - before[2],
        failures("messages", what, wrong),
        max(slowest, took),
        page.memory - before[0],
    )


def judged_in(port: int, timeout: float = 30) -> float:
    """Time until a page says that a formula names no region [s]; infinite if it does not."""
    with Tab(port) as tab:
        if not tab.loaded.wait(timeout):
            return math.inf
        name, began = f"Q{time.monotonic_ns()}", time.monotonic()
        tab.set(tab.labelled("Formula")["uuid"], f"F_[0:5]({name})")
        while time.monotonic() < began + timeout:
            if any(name in str(message.get("updates")) for message in list(tab.later)):
                return time.monotonic() - began
            time.sleep(0.01)
    return math.inf


def _fitting(chance: Random, tab: Tab) -> Any:
    """A value that the control may have."""
    controls = [c for c in tab.controls() if not SLOW.match(c["props"].get("label") or "")]
    control = chance.choice([c for c in controls if _value(chance, c) is not None])
    return _update(control["uuid"], {"value": _value(chance, control)})


def _value(chance: Random, control: dict[str, Any]) -> Any:
    props, kind = control["props"], control["type"]
    if kind in ("GuiSliderMessage", "GuiNumberMessage"):
        low, high = props["min"] or 0, props["max"] if props["max"] is not None else 99
        whole = float(props["step"]).is_integer()
        return chance.randint(int(low), int(high)) if whole else chance.uniform(low, high)
    makers: dict[str, Callable[[], Any]] = {
        "GuiCheckboxMessage": lambda: chance.random() < 0.5,
        "GuiButtonMessage": lambda: True,
        "GuiTextMessage": lambda: chance.choice([each for each in JUNK if isinstance(each, str)]),
        "GuiDropdownMessage": lambda: chance.choice(props["options"]),
        "GuiButtonGroupMessage": lambda: chance.choice(props["options"]),
        "GuiRgbMessage": lambda: [chance.randint(0, 255) for _ in range(3)],
        "GuiVector2Message": lambda: [chance.uniform(-9, 9) for _ in range(2)],
        "GuiVector3Message": lambda: [chance.uniform(-9, 9) for _ in range(3)],
    }
    return makers[kind]() if kind in makers else None


def _task(chance: Random, tab: Tab) -> Any:
    """One of three tasks of one robot, without waiting for the last to open."""
    names = ("linear-01", "linear-02", "linear-03")
    return _update(tab.labelled("Task")["uuid"], {"value": chance.choice(names)})


def _unfitting(chance: Random, tab: Tab) -> Any:
    """Anything as the value of any control but a text field, which may have any text."""
    controls = [c for c in tab.controls() if not SLOW.match(c["props"].get("label") or "")]
    return _update(chance.choice(controls)["uuid"], {"value": chance.choice(JUNK)})


def _attribute(chance: Random, tab: Tab) -> Any:
    names = ["removed", "update_cb", "props", "uuid", "is_button", "visible", "__class__", "value"]
    chosen = {chance.choice(names): chance.choice(JUNK) for _ in range(3)}
    return _update(chance.choice(tab.controls())["uuid"], chosen)


def _scene(chance: Random, tab: Tab) -> Any:
    """Cameras, clicks, drags and commands with numbers in bounds and out of them."""

    def number() -> float:
        return chance.choice([0.0, 1.0, chance.uniform(-9, 9), 1e9, 1e30, math.nan, math.inf])

    def numbers(count: int) -> list[float]:
        tame = chance.random() < 0.7
        return [chance.uniform(-5, 5) if tame else number() for _ in range(count)]

    def whose(found: list[dict[str, Any]], field: str) -> str:
        return chance.choice(found)[field] if found else "none"

    nodes = [each for each in tab.replayed if "name" in each]
    place = {"instance_index": chance.choice([None, 0, -1, 2**40]), "owner": ""}
    held = {"name": whose(nodes, "name"), "modifier": chance.choice([None, "shift", "cmd/ctrl"])}
    return chance.choice(
        [
            CAMERA | {"position": numbers(3), "look_at": numbers(3)},
            CAMERA | {"wxyz": numbers(4), "image_height": number(), "fov": number()},
            {"type": "SceneNodeClickMessage", "ray_origin": numbers(3), "ray_direction": numbers(3)}
            | {"screen_pos": numbers(2)}
            | place
            | held,
            {"type": "SceneNodeDragMessage", "phase": chance.choice(["start", "update", "end"])}
            | {"start_position": numbers(3), "start_screen_pos": numbers(2), "button": "left"}
            | {"end_position": numbers(3), "end_screen_pos": numbers(2)}
            | place
            | held,
            {"type": "CommandTriggerMessage", "uuid": whose(_commands(tab), "uuid")},
        ]
    )


def _commands(tab: Tab) -> list[dict[str, Any]]:
    commands = [each for each in tab.replayed if each["type"] == "RegisterCommandMessage"]
    return [each for each in commands if not SLOW.match(each["props"]["label"])]


def _mutated(chance: Random, tab: Tab) -> bytes:
    """A message with some bytes of its encoding changed."""
    raw = bytearray(
        msgspec.msgpack.encode(chance.choice([_scene, _attribute, _fitting])(chance, tab))
    )
    for _ in range(chance.randint(1, 4)):
        raw[chance.randrange(len(raw))] = chance.randrange(256)
    return bytes(raw)


def _bytes(chance: Random, tab: Tab) -> bytes | str:
    del tab
    made = chance.randbytes(chance.randint(0, 300))
    nested = chance.choice([b"\x91", b"\x81\xa1a"]) * chance.randint(1, 100_000)
    return chance.choice([made, nested, made.hex(), b"\xdf\xff\xff\xff\xff" + made])


def _update(uuid: str, updates: dict[str, Any]) -> dict[str, Any]:
    return {"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates}
