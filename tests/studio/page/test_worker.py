"""Threads of the page end when asked to, at the latest with Python."""

import subprocess
import sys
import threading

from studio.page.worker import Worker
from tests.studio.waiting import PATIENCE

# A thread that goes in and out of compiled code while Python ends: torn off in there, it aborts
# the process with status -6.
LEFT = """
import threading
import jax
from studio.page.worker import Worker
begun, closed = threading.Event(), threading.Event()
def work():
    while not closed.is_set():
        jax.jit(lambda x: x + 1)(1.0).block_until_ready()
        begun.set()
worker = Worker("left", work, closed.set)
begun.wait()
"""


def test_python_waits_for_a_worker_that_nobody_has_closed():
    command = [sys.executable, "-c", LEFT]
    ended = subprocess.run(command, check=False, capture_output=True, text=True)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_closing_says_whether_the_thread_has_ended():
    asked, done = threading.Event(), threading.Event()

    def work() -> None:
        done.wait(PATIENCE)

    worker = Worker("slow", work, asked.set)
    assert worker.alive and not worker.close(wait=0.01) and asked.is_set()
    done.set()
    assert worker.close(wait=PATIENCE) and not worker.alive
