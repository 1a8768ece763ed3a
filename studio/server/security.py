"""What keeps the page to the person who started it.

The viewer library listens on every interface, checks no Origin and lets any client open a public
tunnel. Here the server binds the loopback interface only; a request whose Host is not a loopback
name (DNS rebinding) or whose Origin is another site (a foreign page that talks to this server) is
refused with 403, websocket handshakes included; the tunnel cannot be opened.

On any other address every request must show a token: in the query of its URL, or in the cookie
that the first answer sets (a browser's websocket sends the cookie, not the query).
"""

import http
import io
import ipaddress
import re
import secrets
import socket
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout, suppress
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
from studio.server.uploads import guard_uploads

LARGEST_MESSAGE = 2**20
"""Bytes of the largest message that a client may send."""

LARGEST_PORT = 65_535

SHORTEST_TOKEN = 8
COOKIE = "tgpo-token"


class AddressError(UserError):
    """An address that the page cannot be served on."""


def chosen_token(host: str, given: str | None) -> str:
    """The token that clients must show: the one given, one made up, or none on loopback.

    Raises:
        AddressError: a token that is easy to guess or does not fit into a URL.
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
        AddressError: says which address or port would do.
    """
    if not token and not _is_loopback(host):
        raise AddressError(
            f"host: {host!r} can be reached from other machines, and the page asks for no "
            "password. Allowed: 127.0.0.1, ::1, localhost; from elsewhere use "
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

    Programs send no Origin; a browser always does when a page opens a websocket. With a token the
    name of the host is free: a foreign page that reaches this server does not have the token.
    """
    hosts, origins = headers.get_all("Host"), headers.get_all("Origin")
    if len(hosts) != 1:
        return False
    if not (_shows(token, headers, path) if token else _is_loopback(_hostname(hosts[0]))):
        return False
    if not origins:
        return True
    split = urlsplit(origins[0])
    return len(origins) == 1 and split.scheme == "http" and split.netloc == hosts[0]


def _shows(token: str, headers: Headers, path: str) -> bool:
    """Whether a request has the token, in its query or in a cookie."""
    shown = parse_qs(urlsplit(path).query).get("token", [])
    for text in headers.get_all("Cookie"):
        with suppress(CookieError):
            cookie = SimpleCookie(text).get(COOKIE)
            shown += [] if cookie is None else [cookie.value]
    return any(secrets.compare_digest(each.encode(), token.encode()) for each in shown)


def start_server(host: str, port: int, label: str, token: str = "") -> viser.ViserServer:
    """A viewer server that answers its own page and nobody else.

    Args:
        host: a loopback address; any address if there is a token.
        port: where to listen.
        label: title of the page.
        token: that every request must show; empty for none.

    Raises:
        AddressError: see `check_address`.
    """
    check_address(host, port, token)
    with _guarded_handshakes(token), redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, label=label, verbose=False)
    if server.get_port() != port:
        server.stop()
        raise AddressError(f"port: {port} on {host} was taken meanwhile; choose another one")
    connection = server._websock_server  # noqa: SLF001
    for message in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        connection.unregister_handler(message)
    guard_uploads(server)
    return server


@contextmanager
def _guarded_handshakes(token: str) -> Iterator[None]:
    """While it is open, servers that start refuse requests that `allows` does not.

    The viewer library has no hook for this; it calls `serve` once, when it is constructed.
    """
    serve = websockets.asyncio.server.serve

    def guarded(handler, host, port, *, process_request, **options):
        def checked(connection, request: Request) -> Response | None:
            if not allows(request.headers, request.path, token):
                body = b"403: this page answers only to itself, under a loopback address\n"
                if token:
                    body = b"403: open the address that the program printed, token included\n"
                headers = Headers({"Content-Type": "text/plain", "Content-Length": str(len(body))})
                return Response(http.HTTPStatus.FORBIDDEN, "Forbidden", headers, body)
            response = process_request(connection, request)
            if response is not None:
                response.headers["Content-Security-Policy"] = "frame-ancestors 'self'"
                response.headers["X-Content-Type-Options"] = "nosniff"
                response.headers["Referrer-Policy"] = "no-referrer"
                if token:
                    cookie = f"{COOKIE}={token}; Path=/; HttpOnly; SameSite=Strict"
                    response.headers["Set-Cookie"] = cookie
            return response

        options["max_size"] = LARGEST_MESSAGE
        return serve(handler, host, port, process_request=checked, **options)

    with patch.object(websockets.asyncio.server, "serve", guarded):
        yield


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
