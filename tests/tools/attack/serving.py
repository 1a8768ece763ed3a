"""A page in a process of its own, and what can be seen of it from outside."""

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

from tests.studio.conftest import free_port

STARTS_IN = 120.0
"""Time within which the page must answer [s]."""


class Served:
    """`python -m studio`, with its state in a folder of our own.

    Args:
        folder: for the state and the log.
        arguments: of the command line, besides the address.
    """

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.port = free_port()
        self.log = folder / f"page-{self.port}.log"
        command = [sys.executable, "-m", "studio", "--no-browser", "--port", str(self.port)]
        with self.log.open("ab") as log:
            self._process = subprocess.Popen(
                [*command, *arguments],
                env=os.environ | {"XDG_STATE_HOME": str(folder), "PYTHONUNBUFFERED": "1"},
                stdout=log,
                stderr=log,
            )
        deadline = time.monotonic() + STARTS_IN
        while b"is running at" not in self.log.read_bytes():
            if self._process.poll() is not None or time.monotonic() > deadline:
                self.kill()
                raise RuntimeError(f"the page did not start:\n{self.log.read_text()[-2000:]}")
            time.sleep(0.05)

    @property
    def alive(self) -> bool:
        """Whether the process runs."""
        return self._process.poll() is None

    @property
    def memory(self) -> float:
        """Resident memory [MB]."""
        for line in Path(f"/proc/{self._process.pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) / 1000
        raise ProcessLookupError(self._process.pid)

    @property
    def tracebacks(self) -> int:
        """Exceptions in the log so far."""
        return self.log.read_bytes().count(b"Traceback (most recent call last)")

    @property
    def dropped(self) -> int:
        """Messages that the gate has dropped, on connections that have ended."""
        return sum(map(int, re.findall(rb"dropped (\d+) messages", self.log.read_bytes())))

    def kill(self) -> None:
        """As `kill -9` does."""
        self._process.kill()
        self._process.wait()

    def stop(self) -> None:
        """As Ctrl+C does."""
        self._process.send_signal(signal.SIGINT)
        try:
            self._process.wait(30)
        except subprocess.TimeoutExpired:
            self.kill()

    def __enter__(self) -> "Served":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()
