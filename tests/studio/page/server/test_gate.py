"""What a browser may send, on a real server, with the library's own encoding."""

import logging
import math
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed

from studio.page.server.gate import Gate
from studio.page.server.messages import LONGEST_TEXT
from studio.page.server.relied_upon import connection_of, identifier_of, kept_messages
from studio.page.server.security import start_server
from tests.studio.conftest import free_port
from tests.studio.waiting import wait_for
from tests.tools.attack.client import CAMERA, Tab, loads


@pytest.fixture(scope="module")
def server():
    server = start_server("127.0.0.1", free_port(), "test")
    yield server
    server.stop()


@dataclass
class Kind:
    """A type of control, a value that it may have and some that it may not."""

    make: Any
    good: Any
    bad: list[Any]


ANY_BAD = [
    None,
    {},
    {"a": 1},
    b"bytes",
    [1e30] * 3,
    [math.nan] * 3,
    1e30,
    math.nan,
    math.inf,
    -1e30,
]
KINDS = {
    "checkbox": Kind(lambda gui: gui.add_checkbox("", False), True, [1, 0, "true", []]),
    "text": Kind(lambda gui: gui.add_text("", ""), "A1", ["x" * (LONGEST_TEXT + 1), True, 1, []]),
    "number": Kind(lambda gui: gui.add_number("", 1.0, min=0.5, max=9), 2, [0.4, 9.1, "2", True]),
    "count": Kind(lambda gui: gui.add_number("", 1), 7, [1.5, 1e9 + 1, 2**64 - 1, "7"]),
    "slider": Kind(lambda gui: gui.add_slider("", 0, 9, 1, 0), 4, [-1, 10, 1.5, "4", [4]]),
    "colour": Kind(
        lambda gui: gui.add_rgb("", (0, 0, 0)),
        [1, 2, 255],
        [[256, 0, 0], [-1, 0, 0], [0, 0], [0] * 4, ["1", "2", "3"], "red"],
    ),
    "vector2": Kind(lambda gui: gui.add_vector2("", (0.0, 0.0)), [1, 2.5], [[1, 2, 3], [1], "12"]),
    "vector3": Kind(
        lambda gui: gui.add_vector3("", (0.0, 0.0, 0.0), min=(0, 0, 0), max=(9, 9, 9)),
        [1, 2.5, 3],
        [[1, 2], [1, 2, 9.5], [-1, 2, 3], [None, 1, 2]],
    ),
    "menu": Kind(lambda gui: gui.add_dropdown("", ("a", "b")), "b", ["c", "", True, 1, ["a"]]),
    "choice": Kind(lambda gui: gui.add_button_group("", ("a", "b")), "b", ["c", 1, True]),
    "button": Kind(lambda gui: gui.add_button(""), True, ["yes", 1]),
    "upload": Kind(lambda gui: gui.add_upload_button(""), None, [True, "file", []]),
    "bar": Kind(lambda gui: gui.add_progress_bar(0), None, [50, 1]),
}


@pytest.mark.parametrize("name", KINDS)
def test_no_value_keeps_a_later_page_from_loading(server, name):
    """`[1e30] * 3` as a colour once closed every later connection."""
    kind = KINDS[name]
    control = kind.make(server.gui)
    before = control.value
    wrong = [*kind.bad, *ANY_BAD]
    with Tab(server.get_port()) as tab:
        dropped = server.gate.dropped.total()
        for value in wrong:
            tab.set(identifier_of(control), value)
        assert wait_for(lambda: server.gate.dropped.total() == dropped + len(wrong))
        assert control.value == before
        if kind.good is not None:
            tab.set(identifier_of(control), kind.good)
            good = tuple(kind.good) if isinstance(kind.good, list) else kind.good
            assert wait_for(lambda: control.value == good)
    for message in list(kept_messages(server).values()):
        msgspec.msgpack.encode(message.as_serializable_dict([]))
    assert loads(server.get_port())
    control.remove()


def test_the_page_uses_no_other_types_of_control(tmp_path):
    """Whoever adds one to the page gets a failure here, and adds it to `KINDS`."""
    from scenes import load_task
    from studio.page.app import Studio

    studio = Studio(load_task("linear-08"), None, "127.0.0.1", free_port(), state=tmp_path)
    try:
        used = {type(control) for control in studio._server.gate.controls.values()}
    finally:
        studio.close()
    scratch = start_server("127.0.0.1", free_port(), "types")
    try:
        assert used <= {type(kind.make(scratch.gui)) for kind in KINDS.values()}
    finally:
        scratch.stop()


@pytest.mark.parametrize("name", ["removed", "update_cb", "props", "uuid", "is_button", "gui_api"])
def test_no_attribute_but_the_value_can_be_set(server, name):
    control = server.gui.add_text("", "")
    update = {"type": "GuiUpdateMessage", "uuid": identifier_of(control)}
    with Tab(server.get_port()) as tab:
        tab.send(update | {"updates": {name: True}})
        tab.send(update | {"updates": {"value": "both", name: True}})
        tab.send(update | {"updates": {}})
        tab.set(identifier_of(control), "arrived")
        assert wait_for(lambda: control.value == "arrived")
    assert getattr(control._impl, name) is not True
    control.remove()


@pytest.mark.parametrize(
    "change",
    [
        {"position": [math.nan, 0, 0]},
        {"position": [1e300, 0, 0]},
        {"wxyz": [1, 0, 0]},
        {"wxyz": "north"},
        {"image_height": math.inf},
        {"image_width": 1e300},
        {"fov": None},
        {"more": 1},
    ],
)
def test_cameras_out_of_bounds_are_dropped(server, change):
    with Tab(server.get_port()) as tab:
        assert wait_for(lambda: len(server.get_clients()) == 1)
        (client,) = server.get_clients().values()
        before = server.gate.dropped.total()
        tab.send(CAMERA | change)
        assert wait_for(lambda: server.gate.dropped.total() == before + 1)
        assert not tab.ended.is_set()
        assert all(map(math.isfinite, client.camera.position))
    assert wait_for(lambda: not server.get_clients())


@pytest.mark.parametrize(
    "message",
    [
        {"type": "GuiFormDirtyMessage", "uuid": "x"},
        {"type": "GuiFormSubmitMessage", "uuid": "x"},
        {"type": "GuiButtonHoldMessage", "uuid": "x", "frequency": 1},
        {"type": "GetRenderResponseMessage", "payload": b"", "render_uuid": ""},
        {"type": "ShareUrlRequest"},
        {"type": "NotificationMessage", "uuid": "x"},
        {"type": "RunJavascriptMessage", "source": "alert(1)"},
        {"type": "CommandTriggerMessage", "uuid": "no such command"},
        {"type": "GuiUpdateMessage", "uuid": "no such control", "updates": {"value": 1}},
        {"type": 5},
        [1, 2],
        b"",
        b"\xc1",
        b"\x91" * 100_000,
        b"\xdf\xff\xff\xff\xff",
        "text",
    ],
    ids=lambda message: str(message)[:30],
)
def test_other_messages_are_dropped_and_leave_nothing(server, message):
    """The library keeps what forms say, for any identifier, for all later clients."""
    with Tab(server.get_port()) as tab:
        assert tab.loaded.wait(10)
        kept, dropped = set(kept_messages(server)), server.gate.dropped.total()
        for _ in range(3):
            tab.send(message)
        assert wait_for(lambda: server.gate.dropped.total() == dropped + 3)
        assert not tab.ended.is_set()
        assert set(kept_messages(server)) == kept


def test_a_flood_of_junk_costs_a_line_for_each_kind(server, caplog):
    before = server.gate.dropped.total()
    with caplog.at_level(logging.WARNING):
        with Tab(server.get_port()) as tab:
            assert tab.loaded.wait(10)
            caplog.clear()  # what earlier tabs, closed by now, have dropped
            for _ in range(50):
                tab.send(b"junk")
                tab.send("text")
            assert wait_for(lambda: server.gate.dropped.total() == before + 100)
        assert wait_for(lambda: len(caplog.records) >= 2)
    assert [record.getMessage().split(":")[0] for record in caplog.records] == [
        "dropped 50 messages from a browser"
    ] * 2


def test_a_repeated_key_does_not_pass_what_the_last_one_hides():
    """What is passed on is encoded from what was checked."""
    gate = Gate()
    gate.controls = {"a": object()}
    raw = msgspec.msgpack.encode({"type": "CommandTriggerMessage", "uuid": "a"})
    gate.commands = {"b": object()}
    doubled = b"\x83" + raw[1:] + msgspec.msgpack.encode("uuid") + msgspec.msgpack.encode("b")
    passed, _ = gate.check(doubled)
    assert passed is not None
    assert msgspec.msgpack.decode(passed) == {"type": "CommandTriggerMessage", "uuid": "b"}
    assert gate.check(raw)[0] is None


def test_the_gate_test_would_notice_a_bricked_page():
    """Positive control: without the gate, one message does keep every later page from loading."""
    server = viser.ViserServer("127.0.0.1", free_port(), verbose=False)
    try:
        control = server.gui.add_rgb("", (0, 0, 0))
        with suppress(ConnectionClosed), Tab(server.get_port()) as tab:  # it may lose its page too
            tab.set(identifier_of(control), [1e30] * 3)
            assert wait_for(lambda: control.value != (0, 0, 0))
        assert connection_of(server).get_message_buffer().message_from_id
        assert not loads(server.get_port(), timeout=2)
    finally:
        server.stop()
