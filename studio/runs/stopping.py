"""Ctrl-C and SIGTERM: the first asks for a clean stop, the second ends the process at once.

While a compiled epoch runs, Python's own signal handlers wait for its end. A second Ctrl-C must
not wait: Python writes the number of every signal to a wake-up socket at once, and a thread reads
it.
"""

import os
import signal
import socket
import threading
from collections.abc import Callable

SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopRequest:
    """Listens for signals while it is entered, in the main thread.

    Attributes:
        requested: whether a stop was requested.
    """

    def __init__(self, asked: Callable[[], None], abort: Callable[[int], None]):
        """Make a listener.

        Args:
            asked: called at the first signal, in another thread.
            abort: called with the number of the second signal, in another thread.
        """
        self._asked, self._abort = asked, abort
        self._event = threading.Event()

    @property
    def requested(self) -> bool:
        """Whether a stop was requested."""
        return self._event.is_set()

    def __enter__(self) -> "StopRequest":
        self._reader, self._writer = socket.socketpair()
        self._writer.setblocking(False)
        self._handlers = {number: signal.getsignal(number) for number in SIGNALS}
        for number in SIGNALS:
            signal.signal(number, lambda *_: None)
        self._previous = signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)
        threading.Thread(target=self._watch, name="signals", daemon=True).start()
        return self

    def __exit__(self, *exception: object) -> None:
        signal.set_wakeup_fd(self._previous)
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self._writer.close()  # the thread reads the end and leaves

    def _watch(self) -> None:
        with self._reader:
            while received := self._reader.recv(1):
                if received[0] not in SIGNALS:
                    continue
                if self._event.is_set():
                    self._abort(received[0])
                else:
                    self._event.set()
                    self._asked()


def abort_process(number: int) -> None:
    """End the process at once with the shell's status for the signal; files are all atomic."""
    os._exit(128 + number)
