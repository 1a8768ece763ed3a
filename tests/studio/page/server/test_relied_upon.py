"""An upgrade of the viewer library fails here, not in a browser."""

import dataclasses
import inspect
from typing import get_args

import msgspec
import pytest
import viser
from viser import _messages

from studio.page.server import messages, relied_upon
from studio.page.server.controls import accepts
from tests.studio.conftest import free_port

ALLOWED = {message.__struct_config__.tag: message for message in get_args(messages.Message)}


def test_the_version_is_the_one_that_was_read():
    assert viser.__version__ == relied_upon.VERSION, (
        "read again what the library does with a browser's messages (_gui_api.py, _scene_api.py, "
        "infra/_infra.py), then set VERSION"
    )


def test_every_message_that_the_library_handles_is_known():
    """On a server, and for one client."""
    server = viser.ViserServer("127.0.0.1", free_port(), verbose=False)
    try:
        handled = {message.__name__ for message in server._websock_server._incoming_handlers}
    finally:
        server.stop()
    handled |= {"GetRenderResponseMessage", "ViewerCameraMessage"}
    assert handled == set(ALLOWED) | messages.UNUSED


@pytest.mark.parametrize("tag", ALLOWED)
def test_fields_are_the_libraries(tag):
    ours = {field.encode_name for field in msgspec.structs.fields(ALLOWED[tag])}
    theirs = {field.name for field in dataclasses.fields(getattr(_messages, tag))}
    assert ours == theirs - {"excluded_self_client"}


def test_what_is_used_beyond_the_interface_is_there():
    server = viser.ViserServer("127.0.0.1", free_port(), verbose=False)
    try:
        field, command = server.gui.add_text("", ""), server.gui.add_command("")
        assert relied_upon.controls_of(server)[relied_upon.identifier_of(field)] is field
        assert relied_upon.commands_of(server)[relied_upon.identifier_of(command)] is command
        assert any(
            getattr(message, "uuid", None) == relied_upon.identifier_of(field)
            for message in relied_upon.kept_messages(server).values()
        )
    finally:
        server.stop()


def test_a_file_reaches_the_callbacks_of_its_button():
    server = viser.ViserServer("127.0.0.1", free_port(), verbose=False)
    try:
        button, seen = server.gui.add_upload_button(""), []
        button.on_upload(lambda event: seen.append(event.target.value.content))
        event = viser.GuiEvent(None, None, button)
        relied_upon.hand_over(event, viser.UploadedFile("a", b"content"))
        assert seen == [b"content"]
        assert button.value.content == b""
    finally:
        server.stop()


def test_acknowledgements_are_the_libraries():
    fields = {field.name for field in dataclasses.fields(_messages.FileTransferPartAck)}
    known = {"source_component_uuid", "transfer_uuid", "transferred_bytes", "total_bytes"}
    assert fields - {"excluded_self_client"} == known


def test_the_library_still_sets_attributes_by_name():
    """The reason for the gate; if this changes, read `_handle_gui_updates` again."""
    source = inspect.getsource(viser.GuiApi._handle_gui_updates)
    assert "setattr(handle_state, prop_name, prop_value)" in source


def test_controls_of_unknown_type_take_nothing():
    assert not accepts(object(), True)
