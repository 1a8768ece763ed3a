"""Uploads as the page sends them, and as it never would."""

import threading

import pytest
import viser

from studio.export.archives import LARGEST_UPLOAD
from studio.page.server.relied_upon import identifier_of, kept_messages
from studio.page.server.security import start_server
from studio.page.server.uploads import MOST_TRANSFERS
from tests.studio.conftest import free_port
from tests.studio.waiting import wait_for
from tests.tools.attack.client import Tab


@pytest.fixture
def server():
    server = start_server("127.0.0.1", free_port(), "test")
    yield server
    server.stop()


@pytest.fixture
def arrived(server):
    """A button, and what its callback has read."""
    button, files = server.gui.add_upload_button("upload"), []
    button.on_upload(lambda event: files.append(event.target.value))
    return button, files


def start(button, name, size, parts, **changes):
    message = {"type": "FileTransferStartUpload", "source_component_uuid": identifier_of(button)}
    message |= {"transfer_uuid": name, "filename": name, "mime_type": "", "part_count": parts}
    return message | {"size_bytes": size} | changes


def part(button, name, index, content):
    message = {"type": "FileTransferPart", "source_component_uuid": identifier_of(button)}
    return message | {"transfer_uuid": name, "part_index": index, "content": content}


def upload(tab, button, name, size, *, declared=None, chunk=500_000):
    """Send a file of zeros as the page does."""
    parts = -(-size // chunk)
    tab.send(start(button, name, declared or size, parts))
    for index in range(parts):
        tab.send(part(button, name, index, bytes(min(chunk, size - index * chunk))))


def acknowledgements(tab):
    return [message for message in tab.later if message["type"] == "FileTransferPartAck"]


def notices(tab):
    return [message for message in tab.later if message["type"].startswith("Notification")]


def test_large_uploads_are_refused_and_small_ones_arrive(server, arrived):
    button, files = arrived
    assert LARGEST_UPLOAD < 60_000_000
    with Tab(server.get_port()) as tab:
        upload(tab, button, "sixty", 60_000_000)
        upload(tab, button, "liar", 2_000_000, declared=1000)
        upload(tab, button, "boaster", 1000, declared=2000)
        upload(tab, button, "../../small", 1_500_000)
        assert wait_for(lambda: len(files) == 1)
        assert wait_for(lambda: len(notices(tab)) > 0)
    assert files[0].name == "../../small"
    assert len(files[0].content) == 1_500_000
    assert wait_for(lambda: server.uploads.in_flight == 0)


def test_nothing_of_an_upload_outlives_it(server, arrived):
    """100 acknowledgements with long identifiers once made every later page load 15 MB."""
    button, files = arrived
    with Tab(server.get_port()) as tab:
        assert tab.loaded.wait(10)
        kept = set(kept_messages(server))
        for number in range(100):
            upload(tab, button, f"empty {number}", 0)
            assert wait_for(lambda n=number: len(files) == n + 1)
            assert wait_for(lambda: server.uploads.in_flight == 0)
        upload(tab, button, "whole", 1_000_000)
        assert wait_for(lambda: len(files) == 101)
        assert wait_for(lambda: server.uploads.in_flight == 0)
        assert wait_for(lambda: len(acknowledgements(tab)) == 102)
        assert set(kept_messages(server)) == kept
        last = acknowledgements(tab)[-1]
    assert last["transferred_bytes"] == last["total_bytes"] == 1_000_000
    assert button.value.content == b""
    with Tab(server.get_port()) as tab:
        assert tab.loaded.wait(10)
        assert tab.replay_bytes < 10_000


def test_acknowledgements_reach_only_the_sender(server, arrived):
    button, files = arrived
    with Tab(server.get_port()) as sender, Tab(server.get_port()) as other:
        assert sender.loaded.wait(10)
        assert other.loaded.wait(10)
        upload(sender, button, "mine", 1000)
        assert wait_for(lambda: len(acknowledgements(sender)) > 0)
        assert not acknowledgements(other)
        assert files


@pytest.mark.parametrize(
    "change",
    [
        {"transfer_uuid": "x" * 300_000},
        {"filename": "x" * 300_000},
        {"mime_type": "x" * 300_000},
        {"part_count": -1},
        {"size_bytes": -1},
        {"part_count": 2**63},
        {"size_bytes": 1.5},
    ],
    ids=str,
)
def test_long_names_and_impossible_sizes_are_dropped(server, arrived, change):
    button, files = arrived
    with Tab(server.get_port()) as tab:
        tab.send(start(button, "name", 0, 0, **change))
        upload(tab, button, "fine", 10)
        assert wait_for(lambda: len(files) == 1)
    assert files[0].name == "fine"
    assert server.gate.dropped.total() == 1


def test_only_buttons_for_uploads_take_files(server, arrived):
    """The library sets the value of any control to the file."""
    button, files = arrived
    field = server.gui.add_text("field", "mine")
    with Tab(server.get_port()) as tab:
        upload(tab, field, "wrong", 10)
        upload(tab, button, "right", 10)
        assert wait_for(lambda: len(files) == 1)
    assert field.value == "mine"


def test_uploads_at_once_are_few_and_end_with_their_sender(server, arrived):
    button, files = arrived
    with Tab(server.get_port()) as tab:
        for number in range(5 * MOST_TRANSFERS):
            tab.send(start(button, f"slow {number}", 10_000_000, 20))
            tab.send(part(button, f"slow {number}", 0, bytes(500_000)))
        assert wait_for(lambda: server.uploads.in_flight == MOST_TRANSFERS)
    assert wait_for(lambda: server.uploads.in_flight == 0)
    with Tab(server.get_port()) as tab:
        upload(tab, button, "after", 10)
        assert wait_for(lambda: len(files) == 1)


def test_an_upload_that_stands_still_makes_room(server, arrived, monkeypatch):
    monkeypatch.setattr("studio.page.server.uploads.PATIENCE", 0.2)
    button, files = arrived
    with Tab(server.get_port()) as idle, Tab(server.get_port()) as tab:
        for number in range(MOST_TRANSFERS):
            idle.send(start(button, f"slow {number}", 1000, 2))
        assert wait_for(lambda: server.uploads.in_flight == MOST_TRANSFERS)
        threading.Event().wait(0.3)
        upload(tab, button, "after", 10)
        assert wait_for(lambda: len(files) == 1)


def test_files_that_wait_for_a_slow_callback_count(server):
    button, go, files = server.gui.add_upload_button("upload"), threading.Event(), []

    @button.on_upload
    def _(event: viser.GuiEvent) -> None:
        go.wait(20)
        files.append(event.target.value.name)

    with Tab(server.get_port()) as tab:
        for number in range(5 * MOST_TRANSFERS):
            upload(tab, button, f"file {number}", 10)
        assert wait_for(lambda: len(notices(tab)) > 0)
        assert server.uploads.in_flight == MOST_TRANSFERS
        go.set()
        assert wait_for(lambda: server.uploads.in_flight == 0)
    assert sorted(files) == [f"file {number}" for number in range(MOST_TRANSFERS)]


def test_refusals_are_told_once_in_a_while(server, arrived):
    button, _ = arrived
    with Tab(server.get_port()) as tab:
        for number in range(200):
            tab.send(start(button, f"big {number}", LARGEST_UPLOAD + 1, 1))
        upload(tab, button, "last", 10)
        assert wait_for(lambda: len(acknowledgements(tab)) > 0)
    assert len(notices(tab)) == 1
