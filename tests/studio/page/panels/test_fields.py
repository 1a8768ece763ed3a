"""What is typed is taken once, when typing has paused; only changes of fields are sent."""

from types import SimpleNamespace

from studio.page.panels import fields
from studio.page.panels.fields import Typing, set_changed


def test_what_was_typed_last_is_taken_once(monkeypatch):
    now = 0.0
    monkeypatch.setattr(fields.time, "monotonic", lambda: now)
    typing = Typing[str]()
    assert typing.take() is None and not typing.waits
    typing.put("a")
    now = 0.9 * fields.PAUSE
    typing.put("ab")
    now = 1.8 * fields.PAUSE
    assert typing.take() is None and typing.waits
    now = 2.0 * fields.PAUSE
    assert typing.take() == "ab" and not typing.waits
    assert typing.take() is None


def test_an_empty_text_is_taken_too(monkeypatch):
    monkeypatch.setattr(fields, "PAUSE", 0.0)
    typing = Typing[str]()
    typing.put("")
    assert typing.take() == ""


class Field(SimpleNamespace):
    """Counts what is sent."""

    sent = 0

    def __setattr__(self, name, value):
        Field.sent += 1
        super().__setattr__(name, value)


def test_only_what_changes_is_sent():
    field = Field(value=1, visible=True)
    set_changed(field, value=1, visible=False)
    assert (field.value, field.visible, Field.sent) == (1, False, 1)
