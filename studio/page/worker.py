"""Threads that work for the page, and that end before Python does.

A daemon thread that comes back from compiled code while Python shuts down is torn off inside JAX or
HiGHS, and the whole process aborts. So Python waits, as it ends, for those that still run.
"""

import atexit
import threading
from collections.abc import Callable
from weakref import WeakSet

WAIT = 3
"""How long a closed page waits for a thread [s]."""


class Worker:
    """A thread of the page; runs from the start until it is closed, or has nothing more to do."""

    def __init__(self, name: str, work: Callable[[], None], stop: Callable[[], None]) -> None:
        """Start.

        Args:
            name: of the thread.
            work: what the thread does.
            stop: makes `work` return soon; called from other threads, perhaps more than once.
        """
        self._stop = stop
        self._thread = threading.Thread(target=work, name=name, daemon=True)
        _workers.add(self)
        self._thread.start()

    @property
    def alive(self) -> bool:
        """Whether it still runs."""
        return self._thread.is_alive()

    def close(self, wait: float | None = WAIT) -> bool:
        """Have it end.

        Args:
            wait: for how long to wait for it [s]; None as long as it takes.

        Returns:
            Whether it has ended; one that compiles may need tens of seconds.
        """
        self._stop()
        self._thread.join(wait)
        return not self.alive


_workers: WeakSet[Worker] = WeakSet()


@atexit.register
def _close_all() -> None:
    for worker in list(_workers):
        worker.close(wait=None)
