"""The server's log: what a browser or another program sends costs one line at most."""

import logging

LOG = logging.getLogger("studio.page.server")

HANDSHAKES = logging.getLogger("studio.page.server.handshakes")
"""For the websocket library, which logs a traceback for each malformed request."""


def _one_line(record: logging.LogRecord) -> bool:
    """Shorten a failed handshake; those that ended before a request came are no news."""
    if record.getMessage() != "opening handshake failed" or record.exc_info is None:
        return True
    error = record.exc_info[1]
    record.msg = f"a malformed request: {error}"[:200]
    record.exc_info = None
    return error is None or not isinstance(error.__cause__, EOFError | ConnectionError)


HANDSHAKES.addFilter(_one_line)
