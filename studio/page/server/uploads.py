"""Uploads, in place of the viewer library's handlers.

The library bounds nothing, keeps every acknowledgement for later clients, and keeps the last file
of each button. Here acknowledgements go to the sender alone, and a file is kept only while the
button's callbacks read it.
"""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import viser
from viser import _messages
from viser.infra import ClientId

from studio.export.archives import LARGEST_UPLOAD
from studio.page.server.relied_upon import (
    connection_of,
    controls_of,
    hand_over,
    identifier_of,
    own_buffer,
)

MOST_PARTS = 4096
MOST_TRANSFERS = 4
"""Simultaneous uploads, over all clients."""
PATIENCE = 30.0
"""Time without a part after which an upload makes room for another [s]."""
QUIET = 2.0
"""Least time between two notices to a client [s]."""


@dataclass
class _Transfer:
    client: ClientId
    button: viser.GuiUploadButtonHandle
    filename: str
    size: int
    """Announced [bytes]."""
    part_count: int
    touched: float
    """When the last part came; monotonic time [s]."""
    parts: dict[int, bytes] = field(default_factory=dict)
    received: int = 0
    """[bytes]."""
    complete: bool = False
    """Whether callbacks read it, or wait for their turn."""


class Uploads:
    """Files on their way; the handlers run on the server's event loop."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._server = server
        self._transfers: dict[str, _Transfer] = {}
        self._noticed: dict[ClientId, float] = {}
        self._delivering = threading.Lock()
        """Held while callbacks read a file, which is on its button meanwhile."""
        connection = connection_of(server)
        for message in (_messages.FileTransferStartUpload, _messages.FileTransferPart):
            connection.unregister_handler(message)
        connection.register_handler(_messages.FileTransferStartUpload, self._start)
        connection.register_handler(_messages.FileTransferPart, self._take)
        server.on_client_disconnect(self._forget)

    @property
    def in_flight(self) -> int:
        """How many uploads have begun and are kept."""
        return len(self._transfers)

    def _start(self, client: ClientId, message: _messages.FileTransferStartUpload) -> None:
        button = controls_of(self._server).get(message.source_component_uuid)
        if not isinstance(button, viser.GuiUploadButtonHandle):
            return
        if client not in self._server.get_clients():
            return
        now, name = time.monotonic(), message.transfer_uuid
        self._drop(lambda transfer: now - transfer.touched > PATIENCE)
        if not (message.size_bytes <= LARGEST_UPLOAD and message.part_count <= MOST_PARTS):
            self._refuse(client, f"Files may have at most {LARGEST_UPLOAD / 2**20:.0f} MiB.")
        elif len(self._transfers) >= MOST_TRANSFERS or name in self._transfers:
            self._refuse(client, "Too many uploads at once; try again later.")
        else:
            transfer = _Transfer(
                client, button, message.filename, message.size_bytes, message.part_count, now
            )
            self._transfers[name] = transfer
            if message.part_count == 0:
                self._acknowledge(name, transfer)
                self._end(name, transfer)

    def _take(self, client: ClientId, message: _messages.FileTransferPart) -> None:
        name, index = message.transfer_uuid, message.part_index
        transfer = self._transfers.get(name)
        if transfer is None or transfer.complete or transfer.client != client:
            return
        if index in transfer.parts or index >= transfer.part_count:
            return
        transfer.parts[index], transfer.touched = message.content, time.monotonic()
        transfer.received += len(message.content)
        if transfer.received > transfer.size:
            del self._transfers[name]
            self._refuse(client, "The file is larger than announced.")
            return
        self._acknowledge(name, transfer)
        if len(transfer.parts) == transfer.part_count:
            self._end(name, transfer)

    def _end(self, name: str, transfer: _Transfer) -> None:
        """Hand the file over on another thread, unless it is not as long as announced."""
        if transfer.received != transfer.size:
            del self._transfers[name]
            self._refuse(transfer.client, "The file is shorter than announced.")
            return
        transfer.complete = True
        threading.Thread(target=self._deliver, args=(name, transfer)).start()

    def _deliver(self, name: str, transfer: _Transfer) -> None:
        client = self._server.get_clients().get(transfer.client)
        try:
            with self._delivering:
                content = b"".join(transfer.parts.pop(i) for i in range(transfer.part_count))
                event = viser.GuiEvent(client, transfer.client, transfer.button)
                hand_over(event, viser.UploadedFile(transfer.filename, content))
        finally:
            self._transfers.pop(name, None)

    def _drop(self, unwanted: Callable[[_Transfer], bool]) -> None:
        """Forget transfers, but none that is being read."""
        for name, transfer in list(self._transfers.items()):
            if not transfer.complete and unwanted(transfer):
                self._transfers.pop(name, None)

    def _acknowledge(self, name: str, transfer: _Transfer) -> None:
        """Tell the sender how far it is; its own buffer keeps nothing."""
        client = self._server.get_clients().get(transfer.client)
        if client is not None:
            own_buffer(client).queue_message(
                _messages.FileTransferPartAck(
                    source_component_uuid=identifier_of(transfer.button),
                    transfer_uuid=name,
                    transferred_bytes=transfer.received,
                    total_bytes=transfer.size,
                )
            )

    def _refuse(self, client: ClientId, why: str) -> None:
        now = time.monotonic()
        handle = self._server.get_clients().get(client)
        if handle is not None and now - self._noticed.get(client, -QUIET) >= QUIET:
            self._noticed[client] = now
            handle.add_notification("Upload refused", why, color="red")

    async def _forget(self, client: viser.ClientHandle) -> None:
        """Drop what a client that has gone was sending."""
        gone = ClientId(client.client_id)
        self._noticed.pop(gone, None)
        self._drop(lambda transfer: transfer.client == gone)
