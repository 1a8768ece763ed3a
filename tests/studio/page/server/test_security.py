import http.client
import socket
from contextlib import ExitStack, suppress

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from studio.page.server.security import (
    LARGEST_MESSAGE,
    MOST_CONNECTIONS,
    AddressError,
    check_address,
    chosen_token,
    start_server,
)
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


TOKEN = "correct-horse"
KEY = b"dGhlIHNhbXBsZSBub25jZQ=="
UPGRADE = (
    b"GET / HTTP/1.1\r\nHost: HOST\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: KEY\r\n"
)


@pytest.fixture(scope="module")
def guarded_server():
    server = start_server("127.0.0.1", free_port(), "test", TOKEN)
    yield server
    server.stop()


def answer(server, path="/", *, cookie=None, websocket=False, host="lab.example:80", origin=None):
    connection = http.client.HTTPConnection("127.0.0.1", server.get_port(), timeout=10)
    connection.putrequest("GET", path, skip_host=True)
    connection.putheader("Host", host)
    if origin is not None:
        connection.putheader("Origin", origin)
    if cookie is not None:
        connection.putheader("Cookie", cookie)
    if websocket:
        connection.putheader("Upgrade", "websocket")
        connection.putheader("Connection", "Upgrade")
        connection.putheader("Sec-WebSocket-Version", "13")
        connection.putheader("Sec-WebSocket-Key", "dGhlIHNhbXBsZSBub25jZQ==")
        connection.putheader("Sec-WebSocket-Protocol", f"viser-v{viser.__version__}")
    connection.endheaders()
    response = connection.getresponse()
    connection.close()
    return response


@pytest.mark.parametrize("websocket", [False, True])
@pytest.mark.parametrize("shown", ["query", "cookie"])
def test_the_token_opens_page_and_websocket(guarded_server, websocket, shown):
    path = f"/?token={TOKEN}" if shown == "query" else "/"
    cookie = f"tgpo-token={TOKEN}" if shown == "cookie" else None
    response = answer(guarded_server, path, cookie=cookie, websocket=websocket)
    assert response.status == (101 if websocket else 200)


@pytest.mark.parametrize("websocket", [False, True])
@pytest.mark.parametrize(
    ("path", "cookie"),
    [
        ("/", None),
        ("/?token=", None),
        ("/?token=wrong-token", None),
        (f"/{TOKEN}", None),
        ("/", "tgpo-token=wrong-token"),
        ("/", f"other={TOKEN}"),
    ],
)
def test_without_the_token_nothing_opens(guarded_server, path, cookie, websocket):
    assert answer(guarded_server, path, cookie=cookie, websocket=websocket).status == 403


def test_the_page_hands_its_websocket_the_token(guarded_server):
    cookie = answer(guarded_server, f"/?token={TOKEN}").headers["Set-Cookie"]
    assert "HttpOnly" in cookie
    assert "SameSite=Strict" in cookie
    response = answer(guarded_server, cookie=cookie.split(";")[0], websocket=True)
    assert response.status == 101


def test_a_token_does_not_open_the_page_to_other_sites(guarded_server):
    foreign = {"cookie": f"tgpo-token={TOKEN}", "origin": "http://evil.example"}
    assert answer(guarded_server, websocket=True, **foreign).status == 403


def test_tokens_are_made_where_they_are_needed():
    assert chosen_token("127.0.0.1", None) == ""
    assert len(chosen_token("0.0.0.0", None)) >= 20
    assert chosen_token("0.0.0.0", None) != chosen_token("0.0.0.0", None)
    check_address("0.0.0.0", free_port(), chosen_token("0.0.0.0", None))


@pytest.mark.parametrize("token", ["", "short", "with space!!", "a" * 300])
def test_tokens_that_do_not_protect_are_refused(token):
    with pytest.raises(AddressError, match="token"):
        chosen_token("0.0.0.0", token)


MALFORMED = [
    b"GET /?token=\xff HTTP/1.1\r\nHost: HOST\r\n\r\n",
    b"GET /\xff HTTP/1.1\r\nHost: HOST\r\n\r\n",
    b"GET //[ HTTP/1.1\r\nHost: HOST\r\n\r\n",
    b"GET /" + b"a" * 500 + b" HTTP/1.1\r\nHost: HOST\r\n\r\n",
    b"GET /" + b"a" * 5000 + b" HTTP/1.1\r\nHost: HOST\r\n\r\n",
    b"GET /%00 HTTP/1.1\r\nHost: HOST\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: HOST\r\nOrigin: http://[\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: HOST\r\nOrigin: http://HOST:99999999\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: HOST\r\nOrigin: \xff\xfe\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: [\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: \xff\r\n\r\n",
    b"GET / HTTP/1.1\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: HOST\r\nAccept-Encoding: a\r\nAccept-Encoding: b\r\n\r\n",
    b"GET / HTTP/1.1\r\nHost: HOST\r\nUpgrade: a\r\nUpgrade: b\r\n\r\n",
    UPGRADE.replace(b"KEY", b"\xff\xfe"),
    UPGRADE.replace(b"KEY", b"short"),
    UPGRADE.replace(b"KEY", KEY) + b"Sec-WebSocket-Protocol: viser-v[/red]\r\n",
    UPGRADE.replace(b"KEY", KEY) + b"Sec-WebSocket-Protocol: viser-v\xff\r\n",
    UPGRADE.replace(b"KEY", KEY) + b"Sec-WebSocket-Protocol: ,;,\r\n",
]


@pytest.mark.parametrize("request_", MALFORMED, ids=lambda raw: repr(raw)[2:60])
@pytest.mark.parametrize("secret", ["", TOKEN])
def test_malformed_requests_are_refused_without_a_traceback(
    server, guarded_server, request_, secret, caplog
):
    """Each once gave 500 and a traceback, or might have."""
    asked = guarded_server if secret else server
    raw = request_.replace(b"HOST", f"127.0.0.1:{asked.get_port()}".encode())
    if not raw.endswith(b"\r\n\r\n"):
        raw += b"\r\n"
    with socket.create_connection(("127.0.0.1", asked.get_port()), timeout=10) as connection:
        connection.sendall(raw)
        connection.settimeout(10)
        status = int(connection.makefile("rb").readline().split()[1])
    assert status in (400, 403, 404, 426)
    assert len(caplog.records) <= 1
    assert not any(record.exc_info for record in caplog.records)
    assert answer(guarded_server, f"/?token={TOKEN}").status == 200


def test_cookies_of_other_programs_do_no_harm(server, guarded_server):
    cookie = "tgpo-token=\xff; =; \xfe"
    assert answer(server, host=f"127.0.0.1:{server.get_port()}", cookie=cookie).status == 200
    assert answer(guarded_server, cookie=cookie).status == 403


def test_tabs_are_few(server):
    with ExitStack() as stack:
        for _ in range(MOST_CONNECTIONS):
            stack.enter_context(open_socket(server))
        assert status(server) == 503
        with pytest.raises(InvalidStatus, match="503"):
            open_socket(server)
    assert wait_for(lambda: status(server) == 200)


def test_bytes_that_are_no_request_cost_one_line(server, caplog):
    for raw in (b"\x16\x03\x01\x02\x00\x01" * 50 + b"\r\n", b"GET\r\n\r\n", b"a" * 20_000):
        caplog.clear()
        with socket.create_connection(("127.0.0.1", server.get_port()), timeout=10) as connection:
            connection.sendall(raw)
            with suppress(ConnectionError):
                connection.recv(1000)
        assert wait_for(lambda: len(caplog.records) == 1)
        assert caplog.records[0].exc_info is None
    assert status(server) == 200


@pytest.mark.parametrize(
    "message",
    [
        b"",
        b"\xff\x00garbage",
        "text",
        msgspec.msgpack.encode([1, 2, 3]),
        msgspec.msgpack.encode({"type": "NoSuchMessage"}),
        msgspec.msgpack.encode({"type": "GuiUpdateMessage"}),
        msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": 5, "updates": "x"}),
    ],
)
def test_malformed_messages_leave_the_server_alive(server, message):
    field = server.gui.add_text("field", "")
    with open_socket(server) as client, suppress(ConnectionClosed):
        client.send(message)
    with open_socket(server) as client:
        client.send(gui_update(field, "alive"))
        assert wait_for(lambda: field.value == "alive")


def test_ten_clients_at_once(server):
    field = server.gui.add_text("field", "")
    with ExitStack() as stack:
        clients = [stack.enter_context(open_socket(server)) for _ in range(10)]
        for number, client in enumerate(clients):
            client.send(gui_update(field, f"from {number}"))
            assert wait_for(lambda n=number: field.value == f"from {n}")
