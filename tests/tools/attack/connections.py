"""Connections to the page: many at once, one after another, and some that never read."""

import http.client
import socket
import tempfile
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from pathlib import Path

from websockets.exceptions import InvalidStatus

from tests.tools.attack.client import Tab, loads, open_socket
from tests.tools.attack.messages import judged_in
from tests.tools.attack.serving import Served
from tests.tools.attack.table import Row, failures, hangs

AT_ONCE = 200
"""Open at a time, of each kind."""


def attack(count: int, seconds: float) -> list[Row]:
    """On a page of its own."""
    with tempfile.TemporaryDirectory() as folder, Served(Path(folder)) as page:
        return attack_page(page, count, seconds)


def attack_page(page: Served, count: int, seconds: float) -> list[Row]:
    """`count` connections altogether; afterwards a new page must work."""
    kinds = {
        "tabs at once": (_tab, AT_ONCE),
        "tabs one by one": (_tab, 1),
        "sockets that never read": (_deaf, AT_ONCE),
        "bare TCP": (_bare, AT_ONCE),
        "half a request": (_half, AT_ONCE),
        "requests": (_request, 1),
    }
    rows, began = [], time.monotonic()
    judged_in(page.port)  # warm
    for what, (connect, at_once) in kinds.items():
        left = max(1.0, seconds - (time.monotonic() - began))
        rows.append(_many(page, what, connect, max(1, count // len(kinds)), at_once, left))
    return rows


def _many(
    page: Served,
    what: str,
    connect: Callable[[ExitStack, int], bool],
    count: int,
    at_once: int,
    seconds: float,
) -> Row:
    """Open them in groups, and close each group."""
    before, traced, slowest = page.memory, page.tracebacks, 0.0
    deadline, tried, served = time.monotonic() + seconds, 0, 0
    while tried < count and time.monotonic() < deadline:
        with ExitStack() as stack:
            for _ in range(min(at_once, count - tried)):
                began = time.monotonic()
                served += connect(stack, page.port)
                slowest = max(slowest, time.monotonic() - began)
                tried += 1
    took = judged_in(page.port)
    wrong = {
        "a new page does not load": not loads(page.port),
        "tracebacks": page.tracebacks - traced,
        "the process is dead": not page.alive,
        **hangs(slowest, took),
    }
    return Row(
        "connections",
        what,
        tried,
        tried - served,
        failures("connections", what, wrong),
        max(slowest, took),
        page.memory - before,
    )


def _tab(stack: ExitStack, port: int) -> bool:
    """A page that loads to its end."""
    with suppress(InvalidStatus):
        return stack.enter_context(Tab(port)).loaded.wait(10)
    return False


def _deaf(stack: ExitStack, port: int) -> bool:
    """Opens the websocket and reads nothing more."""
    with suppress(InvalidStatus):
        connection = open_socket(port, max_queue=1, close_timeout=0.1)
        stack.callback(connection.socket.close)
        return True
    return False


def _bare(stack: ExitStack, port: int) -> bool:
    stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=10))
    return True


def _half(stack: ExitStack, port: int) -> bool:
    connection = stack.enter_context(socket.create_connection(("127.0.0.1", port), timeout=10))
    connection.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1")
    return True


def _request(stack: ExitStack, port: int) -> bool:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    stack.callback(connection.close)
    connection.request("GET", "/")
    return connection.getresponse().status == 200
