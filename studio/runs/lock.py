"""One writer for each run: a lock that ends with its process, however it ends."""

import os
import socket
from contextlib import suppress
from pathlib import Path

import msgspec
from filelock import FileLock, Timeout

from core.checkpoint import remove_leftovers, write_atomically
from studio.runs.config import RunError

LOCK = "lock"
"""Held by the writer; the file stays."""

HOLDER = "lock.json"
"""Who holds it."""

FILES = frozenset({LOCK, HOLDER})


class Holder(msgspec.Struct):
    """A process that writes a run."""

    pid: int
    host: str


class RunLock:
    """Keeps other processes from writing a run until `release`."""

    def __init__(self, folder: Path):
        """Take the lock of a run's folder.

        Raises:
            RunError: another process holds it; the message says which.
            OSError: the folder cannot be written.
        """
        self._holder = folder / HOLDER
        # Held by the run, whichever thread closes it.
        self._lock = FileLock(folder / LOCK, blocking=False, thread_local=False)
        try:
            self._lock.acquire()
        except Timeout as error:
            raise RunError(f"{folder}: in use by {_holder_text(self._holder)}") from error
        remove_leftovers(folder)  # of writers that were killed
        holder = Holder(os.getpid(), socket.gethostname())
        write_atomically(self._holder, msgspec.json.encode(holder))

    def release(self) -> None:
        """Let others write the run."""
        if self._lock.is_locked:
            with suppress(OSError):
                self._holder.unlink()
            self._lock.release()


def _holder_text(path: Path) -> str:
    try:
        holder = msgspec.json.decode(path.read_bytes(), type=Holder)
    except (OSError, msgspec.MsgspecError, ValueError, RecursionError):
        return "another process"
    return f"process {holder.pid} on {holder.host}; wait for it, or stop it"
