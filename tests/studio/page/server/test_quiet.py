"""Two exports at once: each starts a server of its own, on a thread of its own."""

import sys
import threading
from contextlib import contextmanager

import pytest
import viser
import websockets.asyncio.server

from studio.page.server import security
from studio.page.server.quiet import quiet


@contextmanager
def untouched():
    """Check that what the server's start replaces for a moment is back in place afterwards."""
    before = (sys.stdout, websockets.asyncio.server.serve)
    yield
    after = (sys.stdout, websockets.asyncio.server.serve)
    sys.stdout, websockets.asyncio.server.serve = before
    assert after == before


def overlapping(work):
    """Run `work(number, arrived)` on two threads, of which the second begins within the first."""
    arrived = [threading.Event(), threading.Event()]
    threads = [threading.Thread(target=work, args=(number, arrived)) for number in range(2)]
    threads[0].start()
    assert arrived[0].wait(30)
    threads[1].start()
    for thread in threads:
        thread.join(30)
        assert not thread.is_alive()


def meet(number, arrived):
    """The first waits a little for the second, and ends before it."""
    arrived[number].set()
    arrived[1].wait(0.5)
    if number == 1:
        threading.Event().wait(0.2)


def test_stdout_is_put_back():
    def work(number, arrived):
        with quiet():
            meet(number, arrived)

    with untouched():
        overlapping(work)


def test_nothing_of_the_library_stays_replaced(monkeypatch):
    numbers, both = iter(range(2)), []

    def server(*_, **__):
        meet(next(numbers), both)
        raise RuntimeError("far enough")

    def work(number, arrived):
        both[:] = arrived
        with pytest.raises(RuntimeError, match="far enough"):
            security.start_server("127.0.0.1", 0, "test")

    monkeypatch.setattr(security, "check_address", lambda *_: None)
    monkeypatch.setattr(viser.ViserServer, "__init__", server)
    with untouched():
        overlapping(work)
