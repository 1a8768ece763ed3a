"""The filter between a browser's messages and the viewer library's handlers.

A message passes if it is one that the page needs, with fields in bounds, for a control or command
that exists and a value that the control may have. Everything else is dropped and counted.
"""

from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

import msgspec
from websockets.asyncio.server import ServerConnection

from studio.page.server.controls import accepts
from studio.page.server.log import LOG
from studio.page.server.messages import CommandTrigger, ControlUpdate, Message, decode, encode


class Gate:
    """One for a server. `dropped` counts the messages that did not pass, by reason."""

    def __init__(self) -> None:
        self.dropped: Counter[str] = Counter()
        self.controls: Mapping[str, Any] = {}
        """The library's handles, by identifier."""
        self.commands: Mapping[str, Any] = {}

    def check(self, raw: str | bytes) -> tuple[bytes | None, str]:
        """The message to pass on, or None and why it is dropped."""
        if isinstance(raw, str):
            return None, "text instead of bytes"
        try:
            message = decode(raw)
        except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
            return None, "a message that the page does not know"
        why = self._complaint(message)
        return (None, why) if why else (encode(message), "")

    def _complaint(self, message: Message) -> str:
        if isinstance(message, ControlUpdate):
            control = self.controls.get(message.uuid)
            if control is None:
                return "a control that does not exist"
            if not accepts(control, message.updates.value):
                return "a value that the control cannot have"
        if isinstance(message, CommandTrigger) and message.uuid not in self.commands:
            return "a command that does not exist"
        return ""


class GatedConnection(ServerConnection):
    """A connection on which only messages arrive that pass the gate."""

    def __init__(self, gate: Gate, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._gate = gate
        self._dropped: Counter[str] = Counter()

    async def recv(self, decode: bool | None = None) -> bytes:  # pyright: ignore[reportIncompatibleMethodOverride]
        """The next message that passes."""
        while True:
            message, why = self._gate.check(await super().recv(decode))
            if message is not None:
                return message
            self._dropped[why] += 1
            self._gate.dropped[why] += 1

    def connection_lost(self, exc: Exception | None) -> None:
        """Log what was dropped: a line for each kind, however much there was."""
        super().connection_lost(exc)
        for why, count in self._dropped.items():
            LOG.warning("dropped %d messages from a browser: %s", count, why)


def gated(gate: Gate) -> Callable[..., GatedConnection]:
    """For the `create_connection` option of `websockets.asyncio.server.serve`."""

    def connection(*arguments: Any, **options: Any) -> GatedConnection:
        return GatedConnection(gate, *arguments, **options)

    return connection
