"""Keep the viewer library's own words off stdout, from whatever thread it is called."""

import io
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout

_LOCK = threading.RLock()


@contextmanager
def quiet() -> Iterator[None]:
    """What is printed inside is dropped; one thread at a time, so that stdout is put back.

    Whoever replaces something else of the library for a moment does it in here, too.
    """
    with _LOCK, redirect_stdout(io.StringIO()):
        yield
