"""Who may pass: every request to a guarded server is judged here, before viser sees it. Floor 10.

Host     is a name this server goes by                      else 421   a name made to resolve to this machine
Origin   is that same Host; a websocket must bring one      else 403   other pages in the same browser; other programs
token    in the address of the page, then in a cookie       else 403   other users of the machine
"""

from __future__ import annotations

import ipaddress
import re
import secrets
import time
from dataclasses import dataclass, field
from html import escape
from typing import TYPE_CHECKING
from urllib.parse import parse_qsl, urlencode

from ..errors import ConfigurationError

if TYPE_CHECKING:
    from websockets.datastructures import Headers
    from websockets.http11 import Request, Response

CLIENTS = 16  # people and tabs at once
_TICKET = 60.0  # seconds in which a browser must come with its ticket
_HTTP_PORT = 80  # left out in addresses
_REASONS = {200: "OK", 303: "See Other", 400: "Bad Request", 403: "Forbidden", 421: "Misdirected Request", 503: "Busy"}
_ONCE = ("Accept-Encoding", "Cookie", "Origin", "Sec-Fetch-Site", "Sec-WebSocket-Protocol", "Upgrade")
_HOST = re.compile(r"(\[[0-9a-f:.]+\]|[a-z0-9._-]+)(?::([0-9]{1,5}))?", re.ASCII)


@dataclass(frozen=True, eq=False)
class Gate:
    """Who may pass: the token, the port, and the (host, port) pairs under which this server is known."""

    token: str
    port: int
    known: frozenset[tuple[str, int]]
    _tickets: dict[str, float] = field(default_factory=dict)  # and until when each is good

    @property
    def cookie(self) -> str:
        """Name of the cookie; cookies know no ports, so it carries ours."""
        return f"kinestatics-{self.port}"

    def new_ticket(self) -> str:
        """A word that opens the page once, soon."""
        ticket = secrets.token_urlsafe(32)
        self._tickets[ticket] = time.monotonic() + _TICKET
        return ticket

    def judge(self, request: Request, arrived_at: str, clients: int, protocol: str) -> Response | None:
        """The answer to a request that viser must not see, or None: it may."""
        headers = request.headers
        hosts = headers.get_all("Host")
        if len(hosts) != 1 or not self._is_ours(hosts[0], arrived_at):
            return answer(421, "This server does not go by that name.")
        if any(len(headers.get_all(name)) > 1 for name in _ONCE) or not request.path.isascii():
            return answer(400, "A header is doubled, or the address is not plain.")
        handshake = headers.get("Upgrade", "").lower() == "websocket"
        origin = headers.get("Origin")
        if (handshake and origin is None) or (origin is not None and not _same_origin(origin, hosts[0])):
            return answer(403, "Only pages of this server may ask that.")
        path, _, query = request.path.partition("?")
        fields = parse_qsl(query, keep_blank_values=True)
        offered = [value for name, value in fields if name == "token"]
        if offered and path == "/" and not handshake:
            rest = urlencode([(name, value) for name, value in fields if name != "token"])
            return self._admit(offered, f"/?{rest}" if rest else "/", headers)
        if not any(_same(value, self.token) for value in _cookies(headers, self.cookie)):
            return answer(403, "Open the address that kinestatics printed: it carries a token.")
        if handshake and headers.get("Sec-WebSocket-Protocol") != protocol:
            return answer(400, "This page is of another version: load it anew.")
        return answer(503, f"{CLIENTS} pages are open already.") if handshake and clients >= CLIENTS else None

    def _admit(self, offered: list[str], onward: str, headers: Headers) -> Response:
        """The token becomes a cookie and leaves the address bar."""
        if len(offered) != 1 or not (_same(offered[0], self.token) or self._redeems(offered[0])):
            return answer(403, "That is not the token of this server: open the address that kinestatics printed.")
        if headers.get("Sec-Fetch-Site") == "cross-site":
            # The link was clicked on somebody's page: a strict cookie would not follow a redirect. A page of ours may go on.
            page = f'<!doctype html><title>kinestatics</title><meta http-equiv="refresh" content="0;url={escape(onward)}">'
            response = answer(200, page, "text/html; charset=utf-8")
        else:
            response = answer(303, "")
            response.headers["Location"] = onward
        response.headers["Set-Cookie"] = f"{self.cookie}={self.token}; HttpOnly; SameSite=Strict; Path=/"
        return response

    def _redeems(self, offered: str) -> bool:
        """Whether this is a ticket that was not used yet; then it is now."""
        found = [ticket for ticket in list(self._tickets) if _same(offered, ticket)]
        return bool(found) and time.monotonic() < self._tickets.pop(found[0], 0.0)

    def _is_ours(self, text: str, arrived_at: str) -> bool:
        """Whether a Host header names this server: as it is known, or by the address at which the request arrived."""
        try:
            host, port = host_and_port(text, "Host")
        except ConfigurationError:
            return False
        port = _HTTP_PORT if port is None else port
        here = _plain(arrived_at)
        at_home = host == here or (host == "localhost" and is_loopback(here))
        return (at_home and port == self.port) or (host, port) in self.known


def is_loopback(host: str) -> bool:
    """True where only this machine can reach a server that listens at `host`.

    Example:
        >>> is_loopback("localhost"), is_loopback("127.0.0.1"), is_loopback("0.0.0.0")
        (True, True, False)
    """
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return host.lower() == "localhost"


def host_and_port(text: str, what: str) -> tuple[str, int | None]:
    """Name or address, as it is compared, and port of "name", "name:port", "[v6]:port"; KS433 where it is none of them."""
    found = _HOST.fullmatch(text.lower())
    if found is None:
        hint = "a name such as cell-3 or cell-3.example.org, an IPv4 address, or an IPv6 address"
        raise ConfigurationError("KS433", f"{what} {text[:80]!r} is neither a name nor an address", hint)
    return _plain(found[1].strip("[]")), None if found[2] is None else int(found[2])


def _plain(host: str) -> str:
    """An address in its one short form, a name as it is."""
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return host
    return str(getattr(address, "ipv4_mapped", None) or address)


def _same_origin(origin: str, host: str) -> bool:
    """Whether a page of `origin` lies on `host`; a default port may be written or not."""
    scheme, _, place = origin.lower().partition("://")
    suffix = f":{_HTTP_PORT}"
    return scheme == "http" and place.removesuffix(suffix) == host.lower().removesuffix(suffix)


def _same(offered: str, right: str) -> bool:
    """Equality that takes the same time wherever they differ."""
    return secrets.compare_digest(offered.encode("utf-8", "surrogateescape"), right.encode())


def _cookies(headers: Headers, name: str) -> list[str]:
    """Every value of that name: a page on another port can set one beside ours."""
    pairs = (part.strip().partition("=") for part in headers.get("Cookie", "").split(";"))
    return [value for key, _, value in pairs if key == name]


def answer(status: int, text: str, kind: str = "text/plain; charset=utf-8") -> Response:
    """A response of ours; what was asked is never repeated in it."""
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    body = f"{text}\n".encode() if text else b""
    headers = Headers({"Content-Type": kind, "Content-Length": str(len(body)), "Connection": "close"})
    return Response(status, _REASONS[status], headers, body)
