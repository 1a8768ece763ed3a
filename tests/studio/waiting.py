"""Waiting for other threads without guessing how long they take."""

import threading
import time
from collections.abc import Callable
from typing import Any

PATIENCE = 240.0
"""After how long nothing is waited for any more [s]: as long as a busy machine needs."""


def wait_for(condition: Callable[[], bool], timeout: float = PATIENCE) -> bool:
    """Poll until the condition holds; what it was then, as it may hold for a moment only."""
    deadline = time.monotonic() + timeout
    while not (held := condition()) and time.monotonic() < deadline:
        time.sleep(0.005)
    return held


def ticked(session: Any, condition: Callable[[], bool]) -> bool:
    """Poll until the condition holds, a tick of the page's session before each look."""

    def check() -> bool:
        session.tick(0.0)
        return condition()

    return wait_for(check)


class Gate:
    """Stands in for a function; each call waits until it is let through."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self.entered, self.open = threading.Semaphore(0), threading.Semaphore(0)

    def __call__(self, *asked: Any) -> Any:
        """Call the function once `open` was released."""
        self.entered.release()
        assert self.open.acquire(timeout=60)
        return self._function(*asked)
