"""Requests with other hosts, origins and tokens, and malformed ones."""

import random
import socket
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import viser

from tests.tools.attack.client import loads
from tests.tools.attack.serving import Served
from tests.tools.attack.table import Row, failures, hangs

TOKEN = "correct-horse-battery"
REFUSED = {400, 403, 404, 405, 426, 431}

HOSTS = ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example", "192.168.0.7", "", "["]
HOSTS += ["]", "\xff", "127.0.0.1@evil.example", "0x7f.1 evil", "a" * 3000, "[::ffff:8.8.8.8]"]
ORIGINS = [
    "http://evil.example",
    "null",
    "",
    "http://[",
    "\xff\xfe",
    "https://SELF",
    "http://SELF.x",
]
ORIGINS += ["http://SELF:1", "file://", "http://SELF/", "http://x@SELF", "HTTP://SELF", "a" * 3000]
TOKENS = ["", "\xff", "wrong-token-here", TOKEN[:-1], TOKEN + "x", TOKEN.upper(), "%ff", "a" * 3000]
PATHS = ["/" + "a" * 300, "/" + "a" * 7000, "//[", "/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd"]
PATHS += ["/..\\..\\etc\\passwd", "/%00", "/\xff", "/assets", "/index.html/x", "*", "http://x/"]
JUNK = [
    "Upgrade: a\r\nUpgrade: b",
    "Sec-WebSocket-Key: \xff",
    "Sec-WebSocket-Protocol: viser-v[/a]",
]
JUNK += ["Sec-WebSocket-Version: 99", "X: " + "a" * 9000, "no colon", ": ", "X: a\r\n" * 200]


def attack(count: int, seconds: float) -> list[Row]:
    """`count` requests, to a page with a token and to one without."""
    rows, began = [], time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for what, given in (("no token", []), ("token", ["--token", TOKEN])):
            own = Path(folder) / what
            own.mkdir()
            with Served(own, *given) as page:
                left = max(1.0, seconds - (time.monotonic() - began))
                rows.append(attack_page(page, what, count // 2, left, bool(given)))
    return rows


def attack_page(page: Served, what: str, count: int, seconds: float, token: bool) -> Row:
    """Ask a page, with or without a token."""
    chance, before, traced = random.Random(what), page.memory, page.tracebacks
    deadline, slowest, tried, refused, odd = time.monotonic() + seconds, 0.0, 0, 0, 0
    for raw in _requests(chance, f"127.0.0.1:{page.port}", token):
        if tried >= count or time.monotonic() > deadline:
            break
        began, status = time.monotonic(), _status(page.port, raw)
        slowest, tried = max(slowest, time.monotonic() - began), tried + 1
        refused += status in REFUSED or status is None
        odd += status is not None and status not in REFUSED
    wrong = {
        "answers other than a refusal": odd,
        "tracebacks": page.tracebacks - traced,
        "lines in the log": max(0, page.log.read_bytes().count(b"\n") - 2 * tried - 10),
        "the process is dead": not page.alive,
        "a new page does not load": not token and not loads(page.port),
        **hangs(slowest),
    }
    bad = failures("headers", what, wrong)
    return Row("headers", what, tried, refused, bad, slowest, page.memory - before)


def _requests(chance: random.Random, own: str, token: bool) -> Iterator[bytes]:
    """Each has at least one thing for which it must be refused."""
    while True:
        wrong = chance.choice(["host", "origin", "path", "junk", *["token"] * token])
        path, host, shown = "/", own, f"token={TOKEN}" if token else "x=1"
        lines = []
        if wrong == "host" and token:
            continue  # any host is allowed with a token
        if wrong == "host":
            host = chance.choice(HOSTS)
        if wrong == "path":
            path = chance.choice(PATHS)
        if wrong == "token":
            shown = "token=" + chance.choice(TOKENS)
            lines += [f"Cookie: tgpo-token={chance.choice(TOKENS)}"] * chance.randint(0, 2)
        if wrong == "origin":
            lines.append("Origin: " + chance.choice(ORIGINS).replace("SELF", own))
        if chance.random() < 0.4 or wrong == "junk":
            lines += ["Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13"]
            lines.append("Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==")
        if wrong == "junk":
            lines.append(chance.choice(JUNK))
        elif "Upgrade: websocket" in lines:
            lines.append(f"Sec-WebSocket-Protocol: viser-v{viser.__version__}")
            if wrong == "path":
                continue  # a websocket opens on any path
        head = "\r\n".join([f"GET {path}?{shown} HTTP/1.1", f"Host: {host}", *lines])
        yield head.encode("latin-1") + b"\r\n\r\n"


def _status(port: int, raw: bytes) -> int | None:
    """Of the answer; None if the connection is cut instead."""
    with socket.create_connection(("127.0.0.1", port), timeout=10) as connection:
        try:
            connection.sendall(raw)
            line = connection.makefile("rb").readline().split()
        except ConnectionError:
            return None
        return int(line[1]) if len(line) > 1 else None
