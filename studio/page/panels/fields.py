"""What panels do with their fields: send only what changes, and wait until typing pauses."""

import time
from typing import Any, Generic, TypeVar

PAUSE = 0.6
"""Pause in typing after which a value is applied and an undo step ends [s]."""

Value = TypeVar("Value")


class Typing(Generic[Value]):
    """What was typed last, kept until typing pauses."""

    def __init__(self) -> None:
        self._value: Value | None = None
        self._due = 0.0

    def put(self, value: Value) -> None:
        """Replace what was typed; the pause begins anew."""
        self._value, self._due = value, time.monotonic() + PAUSE

    @property
    def waits(self) -> bool:
        """Something was typed that nobody has taken yet."""
        return self._value is not None

    def take(self) -> Value | None:
        """What was typed, once; None while typing goes on, or if nothing was."""
        if self._value is None or time.monotonic() < self._due:
            return None
        value, self._value = self._value, None
        return value


def set_changed(field: Any, **properties: Any) -> None:
    """Set properties of a field; only those that change are sent."""
    for name, value in properties.items():
        if getattr(field, name) != value:
            setattr(field, name, value)
