"""Access control: only the person who started the page can use it.

The viewer library listens on every interface, checks no Origin and lets any client open a public
tunnel. Here the server binds the loopback interface only; a request whose Host is not a loopback
name (DNS rebinding) or whose Origin is another site (a foreign page that talks to this server) is
refused with 403, websocket handshakes included; the tunnel cannot be opened.

On any other address every request must present a token: in the query of its URL, or in the cookie
set by the first response (a browser's websocket sends the cookie, not the query).
"""

import http
import ipaddress
import re
import secrets
import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from http.cookies import CookieError, SimpleCookie
from unittest.mock import patch
from urllib.parse import parse_qs, urlsplit

import viser
import viser.infra
import websockets.asyncio.server
from viser import _messages
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from core.errors import UserError
from studio.page.server.gate import Gate, gated
from studio.page.server.log import HANDSHAKES, LOG
from studio.page.server.quiet import quiet
from studio.page.server.relied_upon import commands_of, connection_of, controls_of
from studio.page.server.uploads import Uploads

LARGEST_MESSAGE = 2**20
"""Size of the largest message that a client may send, in bytes."""

MOST_CONNECTIONS = 50
"""Tabs that show the page at once; each costs about 1.5 MB."""

LONGEST_PATH = 1000
"""Characters of a request's path and query."""

LARGEST_PORT = 65_535

SHORTEST_TOKEN = 8
COOKIE = "tgpo-token"


class AddressError(UserError):
    """An address on which the page cannot be served."""


def chosen_token(host: str, given: str | None) -> str:
    """The token that clients must present: the given one, a random one, or none on loopback.

    Raises:
        AddressError: a token that is easy to guess or not allowed in a URL.
    """
    if given is None:
        return "" if _is_loopback(host) else secrets.token_urlsafe(16)
    if not re.fullmatch(rf"[A-Za-z0-9_-]{{{SHORTEST_TOKEN},200}}", given):
        raise AddressError(
            f"token: needs at least {SHORTEST_TOKEN} characters, each a letter, digit, - or _"
        )
    return given


def check_address(host: str, port: int, token: str = "") -> None:
    """Refuse addresses that others could reach without a token, and ports that are taken.

    Raises:
        AddressError: names an address or port that can be used.
    """
    if not token and not _is_loopback(host):
        raise AddressError(
            f"host: {host!r} can be reached from other machines, and no token is set. "
            "Allowed: 127.0.0.1, ::1, localhost; from another machine, use "
            "`ssh -L 8080:localhost:8080`"
        )
    if not 1 <= port <= LARGEST_PORT:
        raise AddressError(f"port: {port} is not between 1 and {LARGEST_PORT}")
    if not is_free(host, port):
        free = next((p for p in range(port + 1, LARGEST_PORT + 1) if is_free(host, p)), None)
        hint = "" if free is None else f"; the next free one is {free}"
        raise AddressError(f"port: {port} on {host} is in use or not permitted{hint}")


def is_free(host: str, port: int) -> bool:
    """Whether a server could listen there now."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError:
            return False
    return True


def allows(headers: Headers, path: str = "/", token: str = "") -> bool:
    """Whether a request comes from this server's own page, or from no page at all.

    Programs send no Origin; a browser always does when a page opens a websocket. With a token, any
    host name is allowed: a foreign page that reaches this server does not have the token.
    """
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) != 1:
        return False
    if not (_shows(token, headers, path) if token else _is_loopback(_hostname(hosts[0]))):
        return False
    return not origins or origins == [f"http://{hosts[0]}"]


def _shows(token: str, headers: Headers, path: str) -> bool:
    """Whether a request has the token, in its query or in a cookie."""
    shown = parse_qs(path.partition("?")[2]).get("token", [])
    for text in headers.get_all("Cookie"):
        with suppress(CookieError):
            cookie = SimpleCookie(text).get(COOKIE)
            shown += [] if cookie is None else [cookie.value]
    return any(
        secrets.compare_digest(each.encode(errors="replace"), token.encode()) for each in shown
    )


class PageServer(viser.ViserServer):
    """A viewer server that answers only its own page, and only with what the page needs.

    `gate.dropped` counts the messages that did not pass.
    """

    def __init__(self, host: str, port: int, label: str, token: str = "") -> None:
        self.gate = Gate()
        with quiet(), _guarded_handshakes(token, self.gate):
            super().__init__(host=host, port=port, label=label, verbose=False)
        for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
            connection_of(self).unregister_handler(message)
        self.gate.controls, self.gate.commands = controls_of(self), commands_of(self)
        self.uploads = Uploads(self)


def start_server(host: str, port: int, label: str, token: str = "") -> PageServer:
    """A viewer server that answers only its own page.

    Args:
        host: a loopback address; any address if there is a token.
        port: where to listen.
        label: title of the page.
        token: that every request must present; empty for none.

    Raises:
        AddressError: see `check_address`.
    """
    check_address(host, port, token)
    server = PageServer(host, port, label, token)
    if server.get_port() != port:
        server.stop()
        raise AddressError(f"port: {port} on {host} has just been taken; choose another one")
    return server


@contextmanager
def _guarded_handshakes(token: str, gate: Gate) -> Iterator[None]:
    """Within this context, new servers refuse the requests that `allows` refuses.

    The viewer library has no hook for this; it calls `serve` once, when it is constructed.
    """
    serve = websockets.asyncio.server.serve

    def guarded(handler, host, port, *, process_request, **options):
        def checked(connection, request: Request) -> Response | None:
            if not allows(request.headers, request.path, token):
                return _plain(
                    http.HTTPStatus.FORBIDDEN,
                    "open the printed address, including its token"
                    if token
                    else "this server answers only its own page, on a loopback address",
                )
            if len(connection.server.connections) >= MOST_CONNECTIONS:
                return _plain(
                    http.HTTPStatus.SERVICE_UNAVAILABLE,
                    f"{MOST_CONNECTIONS} tabs show this page; close some",
                )
            try:
                response = _well_formed(request) and process_request(connection, request)
            except Exception as error:  # noqa: BLE001 - the library answers 500 and a traceback
                LOG.warning("a malformed request: %s", type(error).__name__)
                response = False
            if response is False:
                return _plain(http.HTTPStatus.BAD_REQUEST, "a malformed request")
            if response is not None:
                response.headers["Content-Security-Policy"] = "frame-ancestors 'self'"
                response.headers["X-Content-Type-Options"] = "nosniff"
                response.headers["Referrer-Policy"] = "no-referrer"
                if token:
                    cookie = f"{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict"
                    response.headers["Set-Cookie"] = cookie
            return response

        options |= {
            "max_size": LARGEST_MESSAGE,
            "create_connection": gated(gate),
            "logger": HANDSHAKES,
        }
        return serve(handler, host, port, process_request=checked, **options)

    with patch.object(websockets.asyncio.server, "serve", guarded):
        yield


def _well_formed(request: Request) -> bool:
    """Whether the library can look for a file of this name, and show the version claimed."""
    protocols = request.headers.get_all("Sec-WebSocket-Protocol")
    keys = request.headers.get_all("Sec-WebSocket-Key")
    return (
        len(request.path) <= LONGEST_PATH
        and request.path.isascii()
        and all(key.isascii() for key in keys)
        and all(re.fullmatch(r"[\w.,+ -]{1,100}", each, re.ASCII) for each in protocols)
    )


def _plain(status: http.HTTPStatus, text: str) -> Response:
    body = f"{status.value}: {text}\n".encode()
    headers = Headers({"Content-Type": "text/plain", "Content-Length": str(len(body))})
    return Response(status.value, status.phrase, headers, body)


def _hostname(host: str) -> str:
    try:
        return urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return ""


def _is_loopback(host: str) -> bool:
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
