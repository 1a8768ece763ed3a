"""Caps on what clients upload, in front of the viewer's own handlers, which have none."""

import viser
from viser import _messages
from viser.infra import ClientId

from studio.files.archives import LARGEST_UPLOAD

MOST_PARTS = 4096
MOST_TRANSFERS = 8
"""Uploads at the same time, of all clients."""


def guard_uploads(server: viser.ViserServer) -> None:
    """Refuse uploads that are too large, lie about their size, or are too many at once."""
    gui, connection = server.gui, server._websock_server  # noqa: SLF001
    begin, take = gui._handle_file_transfer_start, gui._handle_file_transfer_part  # noqa: SLF001
    transfers = gui._current_file_upload_states  # noqa: SLF001

    def start(client: ClientId, message: _messages.FileTransferStartUpload) -> None:
        fits = 0 <= message.size_bytes <= LARGEST_UPLOAD and 0 <= message.part_count <= MOST_PARTS
        if not fits:
            _refuse(server, client, f"A file has at most {LARGEST_UPLOAD / 2**20:.0f} MiB.")
        elif len(transfers) >= MOST_TRANSFERS or message.transfer_uuid in transfers:
            _refuse(server, client, "Too many uploads at once; try again.")
        else:
            begin(client, message)

    def part(client: ClientId, message: _messages.FileTransferPart) -> None:
        transfer = transfers.get(message.transfer_uuid)
        if transfer is None or transfer["client_id"] != client:
            return
        if transfer["transferred_bytes"] + len(message.content) > transfer["total_bytes"]:
            transfers.pop(message.transfer_uuid, None)
            _refuse(server, client, "The file is larger than it was said to be.")
        else:
            take(client, message)

    connection.unregister_handler(_messages.FileTransferStartUpload)
    connection.register_handler(_messages.FileTransferStartUpload, start)
    connection.unregister_handler(_messages.FileTransferPart)
    connection.register_handler(_messages.FileTransferPart, part)


def _refuse(server: viser.ViserServer, client: ClientId, why: str) -> None:
    handle = server.get_clients().get(client)
    if handle is not None:
        handle.add_notification("Upload refused", why, color="red")
