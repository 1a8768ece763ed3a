"""Memory that was freed in pieces goes back to the system."""

import ctypes
from pathlib import Path

import pytest

from scenes import load_task
from studio.page import session
from studio.page.memory import give_back
from studio.page.session import Session

PIECE, PIECES = 60_000, 2_000


def resident() -> float:
    """Memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 1e6


def test_pieces_below_one_in_use_are_returned():
    """Without the call the C library keeps them: there is something in use above."""
    library = ctypes.CDLL(None)
    library.malloc.restype = ctypes.c_void_p
    library.free.argtypes = [ctypes.c_void_p]
    pieces = [library.malloc(PIECE) for _ in range(PIECES)]
    for piece in pieces:
        ctypes.memset(piece, 1, PIECE)
    last = pieces.pop()
    for piece in pieces:
        library.free(piece)
    before = resident()
    give_back()
    returned = before - resident()
    library.free(last)
    assert returned > 0.8 * PIECE * PIECES / 1e6


def test_a_change_of_task_gives_back(monkeypatch):
    calls = []
    monkeypatch.setattr(session, "give_back", lambda: calls.append(1))
    page = Session(load_task("linear-08"), None, lambda *_: pytest.fail("no training"))
    try:
        page.open(load_task("linear-01"))
    finally:
        page.close()
    assert calls == [1]
