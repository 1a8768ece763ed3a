"""A browser's side of the page's websocket, without a browser."""

import math
import threading
import time
from contextlib import suppress
from typing import Any

import msgspec
import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Subprotocol

CAMERA: dict[str, Any] = {
    "type": "ViewerCameraMessage",
    "wxyz": [1, 0, 0, 0],
    "position": [0.5, 0.5, 9],
    "fov": 1.3,
    "near": 0.01,
    "far": 1000,
    "image_height": 900,
    "image_width": 1440,
    "look_at": [0, 0, 0],
    "up_direction": [0, 0, 1],
}


def open_socket(port: int, **options: Any) -> ClientConnection:
    """A connection as the page opens it; nothing has been sent on it."""
    return connect(
        f"ws://127.0.0.1:{port}",
        subprotocols=[Subprotocol(f"viser-v{viser.__version__}")],
        max_size=None,
        proxy=None,
        **options,
    )


def messages_in(raw: bytes) -> list[dict[str, Any]]:
    """What one frame from the server carries, without its binary arrays."""
    compressed = int.from_bytes(raw[8:16], "little")
    inner = zstandard.ZstdDecompressor().decompress(raw[16 : 16 + compressed])
    return msgspec.msgpack.decode(inner)["messages"]


class Tab:
    """A tab that shows the page: it has sent its camera, reads all the time, and can send.

    Attributes:
        replayed: messages of the first load, by type; complete once `loaded` is set.
        acknowledged: bytes that the server says it has of the last upload.
        replay_bytes: size of the first load.
    """

    def __init__(self, port: int) -> None:
        self._socket = open_socket(port)
        self.replayed: list[dict[str, Any]] = []
        self.replay_bytes = 0
        self.loaded, self.ended = threading.Event(), threading.Event()
        self.later: list[dict[str, Any]] = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.send(CAMERA)

    def send(self, message: Any) -> None:
        """Send a message (a dictionary with a type), raw bytes, or text."""
        raw = isinstance(message, bytes | str)
        self._socket.send(message if raw else msgspec.msgpack.encode(message))

    def set(self, uuid: str, value: Any) -> None:
        """Give a control a value."""
        self.send({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}})

    def ping(self, timeout: float = 30) -> float:
        """Time until the server answers a ping [s]; infinite if it does not."""
        began = time.monotonic()
        try:
            answered = self._socket.ping().wait(timeout)
        except ConnectionClosed:
            return math.inf
        return time.monotonic() - began if answered else math.inf

    def controls(self) -> list[dict[str, Any]]:
        """The controls that were created, as the page receives them."""
        return [each for each in self.replayed if "container_uuid" in each]

    def labelled(self, *labels: str) -> dict[str, Any]:
        """The control with one of these labels."""
        found = [each for each in self.controls() if each["props"].get("label") in labels]
        assert len(found) == 1, (labels, [each["props"].get("label") for each in self.controls()])
        return found[0]

    def __enter__(self) -> "Tab":
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()
        self._reader.join(5)

    def _read(self) -> None:
        with suppress(ConnectionClosed):
            for raw in self._socket:
                assert isinstance(raw, bytes)
                for message in messages_in(raw):
                    if message["type"] == "ReplayDoneMessage":
                        self.loaded.set()
                    else:
                        (self.later if self.loaded.is_set() else self.replayed).append(message)
                if not self.loaded.is_set():
                    self.replay_bytes += len(raw)
        self.ended.set()


def loads(port: int, timeout: float = 20) -> bool:
    """Whether a new page works: everything arrives, and its connection stays open."""
    with suppress(ConnectionClosed), Tab(port) as tab:
        return tab.loaded.wait(timeout) and not tab.ended.wait(0.05)
    return False
