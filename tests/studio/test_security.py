import http.client
import socket

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from studio.security import LARGEST_MESSAGE, AddressError, check_address, start_server
from tests.studio.conftest import free_port
from tests.studio.waiting import wait_for


@pytest.fixture(scope="module")
def server():
    server = start_server("127.0.0.1", free_port(), "test")
    yield server
    server.stop()


def status(server, *, host=None, origin=None, websocket=False) -> int:
    """Status of a hand-made request to the server."""
    port = server.get_port()
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=10)
    connection.putrequest("GET", "/", skip_host=True)
    connection.putheader("Host", (host or "127.0.0.1:PORT").replace("PORT", str(port)))
    if origin is not None:
        connection.putheader("Origin", origin.replace("PORT", str(port)))
    if websocket:
        connection.putheader("Upgrade", "websocket")
        connection.putheader("Connection", "Upgrade")
        connection.putheader("Sec-WebSocket-Version", "13")
        connection.putheader("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ==")
        connection.putheader("Sec-WebSocket-Protocol", f"viser-v{viser.__version__}")
    connection.endheaders()
    code = connection.getresponse().status
    connection.close()
    return code


@pytest.mark.parametrize("host", [None, "localhost:PORT", "localhost:9000", "[::1]:PORT"])
def test_the_page_is_served_under_loopback_names(server, host):
    assert status(server, host=host) == 200


@pytest.mark.parametrize(
    "host",
    ["evil.example", "evil.example:PORT", "127.0.0.1.evil.example", "192.168.0.7:PORT", "]["],
)
@pytest.mark.parametrize("websocket", [False, True])
def test_other_hosts_are_refused(server, host, websocket):
    assert status(server, host=host, websocket=websocket) == 403


@pytest.mark.parametrize("origin", [None, "http://127.0.0.1:PORT"])
def test_own_origin_may_open_a_websocket(server, origin):
    assert status(server, origin=origin, websocket=True) == 101


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "null",
        "",
        "http://127.0.0.1:1",
        "https://127.0.0.1:PORT",
        "http://127.0.0.1:PORT.evil.example",
        "http://localhost:PORT",
    ],
)
@pytest.mark.parametrize("websocket", [False, True])
def test_foreign_origins_are_refused(server, origin, websocket):
    assert status(server, origin=origin, websocket=websocket) == 403


def test_other_sites_cannot_frame_the_page(server):
    connection = http.client.HTTPConnection("127.0.0.1", server.get_port(), timeout=10)
    connection.request("GET", "/")
    headers = connection.getresponse().headers
    assert headers["Content-Security-Policy"] == "frame-ancestors 'self'"


def open_socket(server):
    return connect(
        f"ws://127.0.0.1:{server.get_port()}",
        subprotocols=[f"viser-v{viser.__version__}"],  # pyright: ignore[reportArgumentType]
        max_size=None,
        proxy=None,
    )


def gui_update(handle: viser.GuiTextHandle, value: str) -> bytes:
    message = {"type": "GuiUpdateMessage", "uuid": handle._impl.uuid, "updates": {"value": value}}
    return msgspec.msgpack.encode(message)


def test_no_client_can_open_a_tunnel(server, monkeypatch):
    requests = []
    monkeypatch.setattr(server, "request_share_url", lambda *_: requests.append("share"))
    field = server.gui.add_text("field", "")
    with open_socket(server) as client:
        client.send(msgspec.msgpack.encode({"type": "ShareUrlRequest"}))
        client.send(gui_update(field, "arrived"))
        assert wait_for(lambda: field.value == "arrived")
    assert requests == []


def test_the_tunnel_test_would_notice_one(monkeypatch):
    """Positive control: without our guard, the same message does ask for a tunnel."""
    requests = []
    server = viser.ViserServer("127.0.0.1", free_port(), verbose=False)
    try:
        monkeypatch.setattr(server, "request_share_url", lambda *_: requests.append("share"))
        with open_socket(server) as client:
            client.send(msgspec.msgpack.encode({"type": "ShareUrlRequest"}))
            assert wait_for(lambda: requests == ["share"])
    finally:
        server.stop()


def test_huge_messages_end_the_connection_and_the_server_lives_on(server):
    field = server.gui.add_text("field", "")
    with open_socket(server) as client, pytest.raises(ConnectionClosed):
        client.send(gui_update(field, "x" * (LARGEST_MESSAGE + 1)))
        while True:
            client.recv(timeout=10)
    with open_socket(server) as client:
        client.send(gui_update(field, "y" * 10_000))
        assert wait_for(lambda: field.value.startswith("y"))
    assert "x" not in field.value


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "example.com", ""])
def test_addresses_that_others_reach_are_refused(host):
    with pytest.raises(AddressError, match=r"Allowed: 127\.0\.0\.1"):
        check_address(host, 8080)


@pytest.mark.parametrize("port", [0, -1, 65_536])
def test_impossible_ports_are_refused(port):
    with pytest.raises(AddressError, match="between 1 and 65535"):
        check_address("127.0.0.1", port)


def test_a_busy_port_is_an_error_that_names_a_free_one():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(AddressError) as error:
            start_server("127.0.0.1", port, "test")
    suggested = int(str(error.value).rsplit(" ", 1)[1])
    assert str(port) in str(error.value)
    assert suggested > port
    check_address("127.0.0.1", suggested)
