"""Uploads: too many, too large, endless, with long names, and damaged ones that arrive."""

import random
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tests.tools.attack.client import Tab, loads
from tests.tools.attack.messages import judged_in
from tests.tools.attack.serving import Served
from tests.tools.attack.table import Row, failures, hangs

PART = 500_000


def attack(count: int, seconds: float) -> list[Row]:
    """On a page of its own."""
    with tempfile.TemporaryDirectory() as folder, Served(Path(folder)) as page:
        return attack_page(page, count, seconds)


def attack_page(page: Served, count: int, seconds: float) -> list[Row]:
    """`count` uploads altogether; afterwards a new page loads no more bytes than before."""
    kinds = {
        "empty, long names": _empty,
        "endless": _endless,
        "too large": _large,
        "longer than announced": _liars,
        "damaged files": _damaged,
    }
    rows, began = [], time.monotonic()
    judged_in(page.port)
    for what, messages in kinds.items():
        left = max(1.0, seconds - (time.monotonic() - began))
        rows.append(_send(page, what, messages, max(1, count // len(kinds)), left))
    return rows


def _send(page: Served, what: str, messages: Any, count: int, seconds: float) -> Row:
    chance, before = random.Random(what), (page.memory, page.tracebacks, page.dropped)
    loaded_bytes = _load(page.port)
    deadline, slowest, sent, refused = time.monotonic() + seconds, 0.0, 0, 0
    while sent < count and time.monotonic() < deadline:
        with Tab(page.port) as tab:
            tab.loaded.wait(20)
            buttons = [c for c in tab.controls() if c["type"] == "GuiUploadButtonMessage"]
            for _ in range(min(20, count - sent)):
                for message in messages(chance, chance.choice(buttons)["uuid"]):
                    tab.send(message)
                sent += 1
                slowest = max(slowest, tab.ping())
            refused += sum(m["type"].startswith("Notification") for m in tab.later)
    took = judged_in(page.port)
    wrong = {
        "a new page does not load": not loads(page.port),
        "a new page loads more than before": _load(page.port) > loaded_bytes + 100_000,
        "tracebacks": page.tracebacks - before[1],
        "the process is dead": not page.alive,
        **hangs(slowest, took),
    }
    return Row(
        "uploads",
        what,
        sent,
        page.dropped - before[2] + refused,
        failures("uploads", what, wrong),
        max(slowest, took),
        page.memory - before[0],
    )


def _load(port: int) -> int:
    """Bytes of a page load."""
    with Tab(port) as tab:
        tab.loaded.wait(20)
        return tab.replay_bytes


def _start(button: str, name: str, size: int, parts: int, **changes: Any) -> dict[str, Any]:
    message = {"type": "FileTransferStartUpload", "source_component_uuid": button, "mime_type": ""}
    message |= {"transfer_uuid": name, "filename": "scene.stl.toml", "part_count": parts}
    return message | {"size_bytes": size} | changes


def _part(button: str, name: str, index: int, content: bytes) -> dict[str, Any]:
    message = {"type": "FileTransferPart", "source_component_uuid": button}
    return message | {"transfer_uuid": name, "part_index": index, "content": content}


def _name(chance: random.Random) -> str:
    return f"{chance.getrandbits(64):x}"


def _empty(chance: random.Random, button: str) -> Iterator[dict[str, Any]]:
    long = "x" * chance.choice([1, 60, 300_000])
    yield _start(button, _name(chance) + long, 0, 0, filename=long)


def _endless(chance: random.Random, button: str) -> Iterator[dict[str, Any]]:
    """Begins, and never ends."""
    name = _name(chance)
    yield _start(button, name, 30_000_000, 60)
    yield _part(button, name, chance.randrange(60), bytes(PART))


def _large(chance: random.Random, button: str) -> Iterator[dict[str, Any]]:
    yield _start(button, _name(chance), chance.choice([10**8, 2**53, 2**63, -1]), 1000)


def _liars(chance: random.Random, button: str) -> Iterator[dict[str, Any]]:
    name = _name(chance)
    yield _start(button, name, 1000, 3)
    for index in (0, 0, 1, 7):
        yield _part(button, name, index, bytes(PART))


def _damaged(chance: random.Random, button: str) -> Iterator[dict[str, Any]]:
    """Arrives, and is neither a project nor a bundle."""
    name, content = _name(chance), chance.randbytes(chance.randint(1, 5000))
    content = chance.choice([content, b"PK\x03\x04" + content, b"[scene]\nname = " + content])
    file = chance.choice(["scene.stl.toml", "bundle.zip", "../../etc/passwd", "\x00", "🤖.zip"])
    yield _start(button, name, len(content), 1, filename=file)
    yield _part(button, name, 0, content)
