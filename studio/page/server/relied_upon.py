"""What the page uses of the viewer library beyond its documented interface, in one place.

`VERSION` is the version for which that was read. `tests/studio/page/server/test_relied_upon.py`
fails for any other, and where what is named here has changed.
"""

from collections.abc import Mapping
from typing import Any

import viser
import viser.infra

VERSION = "1.1.1"


def connection_of(server: viser.ViserServer) -> viser.infra.WebsockServer:
    """What receives and sends a server's messages."""
    return server._websock_server  # noqa: SLF001


def controls_of(server: viser.ViserServer) -> Mapping[str, Any]:
    """Handles of the controls that all clients share, by identifier."""
    return server.gui._gui_input_handle_from_uuid  # noqa: SLF001


def commands_of(server: viser.ViserServer) -> Mapping[str, Any]:
    """Handles of the commands, by identifier."""
    return server.gui._command_handle_from_uuid  # noqa: SLF001


def identifier_of(control: Any) -> str:
    """Of a control or a command."""
    return control._impl.uuid  # noqa: SLF001


def own_buffer(client: viser.ClientHandle) -> viser.infra.WebsockClientConnection:
    """Sends to one client; nothing is kept for later ones."""
    return client._websock_connection  # noqa: SLF001


def hand_over(event: viser.GuiEvent[viser.GuiUploadButtonHandle], file: viser.UploadedFile) -> None:
    """Have a button's callbacks read a file, which the button holds no longer than that."""
    state = event.target._impl  # noqa: SLF001
    state.value = file
    try:
        for callback in state.update_cb:
            callback(event)
    finally:
        state.value = viser.UploadedFile("", b"")


def kept_messages(server: viser.ViserServer) -> Mapping[int, viser.infra.Message]:
    """What every later client receives when it connects."""
    return connection_of(server).get_message_buffer().message_from_id
