"""A viser server that only the person who started it can open. Floor 10.

viser listens where it is told, but answers whoever asks: any page open in the same browser, any other user of the machine,
any name that was made to resolve to it; and any client may have it open a public tunnel. Here every request passes a gate
(`guard_gate`) before viser sees it, and so does every message of a client (`guard_messages`); the page may run no script but
its own (`guard_policy`). viser 1.1 offers no hook for this: the function with which it starts to serve is wrapped while it
starts, and what of its inside is relied on is checked (KS431).

What remains: the connection is not encrypted, and browsers send a cookie to every port of the same host name, so another
server that its owner opens at the same name sees it. On a machine shared with people you do not trust, do not open theirs.
"""

from __future__ import annotations

import contextlib
import functools
import logging
import re
import secrets
import socket
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from ..errors import ConfigurationError, KinestaticsError, missing_extra
from .guard_gate import Gate, host_and_port
from .guard_messages import ADMITTED, TUNNEL, careful_connection
from .guard_policy import content_policy, hashes_of_scripts

if TYPE_CHECKING:
    import viser
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

_VERSION = "1.1"  # of viser: inside, others may differ
_LAST_PORT = 65535
_LARGEST = 16 * 2**20  # bytes of one message from a client
_OPENING, _CLOSING = 5.0, 2.0  # seconds a client may take for a handshake, and for saying goodbye
_TOKEN = re.compile(r"[A-Za-z0-9_-]{22,200}")
_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
_ONE_AT_A_TIME = threading.RLock()  # while one server starts or stops, functions of others are wrapped
_LOG = logging.getLogger("kinestatics.guard")
_LOG.addFilter(lambda record: record.getMessage() != "opening handshake failed")  # strangers do not write on our terminal


@dataclass(frozen=True, eq=False)
class GuardedServer:
    """A running viser server behind the gate; a context manager that stops it.

    Attributes:
        server: the viser.ViserServer, for its `scene` and `gui`.
        address: the one address that opens it; whoever knows it can, so it is shown to nobody else.

    Example:
        >>> with guarded_server(label="panda") as guarded:
        ...     guarded.address.startswith("http://127.0.0.1:"), "?token=" in guarded.address
        (True, True)
    """

    server: viser.ViserServer
    address: str
    _gate: Gate = field(repr=False)

    def open_in_browser(self) -> bool:
        """Open the page in this user's browser; False where there is none.

        Other users of the machine can read what programs are started with, so the browser gets a ticket that opens the page
        once, within a minute, in place of the token.
        """
        import webbrowser

        return webbrowser.open(f"{self.address.partition('?')[0]}?token={self._gate.new_ticket()}")

    def stop(self) -> None:
        """Close the socket, every connection and the threads; more than once does no harm."""
        with _quietly():
            self.server.stop()

    def __enter__(self) -> GuardedServer:
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def guarded_server(
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    token: str | None = None,
    also_known_as: Sequence[str] = (),
    label: str | None = None,
) -> GuardedServer:
    """Start a viser server that answers only those who know its address, token included.

    A request is answered when its Host is the address at which it arrived, `host`, or one of `also_known_as`; when its
    Origin, which a websocket must name, is that same Host; and when it brings the token, in the address of the page or in
    the cookie that is then set. All else is refused: 421 for the Host, 403 for the rest. A name that merely resolves to this
    machine is refused too, also where the server listens at "0.0.0.0" or "::" (all addresses; no Hosts themselves).

    Args:
        host: address or name to listen at; other machines reach it only where this is not loopback.
        port: TCP port; 0 takes a free one.
        token: at least 22 letters, digits, "-" or "_"; default a random one of 256 bits.
        also_known_as: further names under which people reach it, each with its port where that differs ("cell-3:9000"),
            for example behind a forwarded port.
        label: title of the page's panel, shown as text.

    Returns:
        The server, with its address.

    Raises:
        ConfigurationError: KS430 the token is too short or has other characters; KS432 nobody can listen at host and port;
            KS433 a name in `host` or `also_known_as` is none.
        MissingExtraError: KS400 viser is not installed.
        KinestaticsError: KS431 the installed viser is of a version whose inside is not known.

    Example:
        >>> guarded = guarded_server(token="a-token-of-my-own-choice")
        >>> guarded.address.endswith("/?token=a-token-of-my-own-choice")
        True
        >>> guarded.stop()
    """
    if token is not None and not _TOKEN.fullmatch(token):
        hint = "at least 22 letters, digits, '-' or '_'; or leave it out and a random one is made"
        raise ConfigurationError("KS430", "the token is too easy to guess, or cannot stand in an address", hint)
    _require_viser()
    named = [host_and_port(name, "also_known_as") for name in also_known_as]
    wanted, given_port = host_and_port(f"[{host}]" if ":" in host else host, "host")
    if given_port is not None:
        raise ConfigurationError("KS433", f"host {host!r} has a port in it", "give the port by itself")
    listening = _listen(wanted, port)
    port = listening.getsockname()[1]
    shown = {"localhost": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}.get(wanted, wanted)
    known = frozenset((name, port if own is None else own) for name, own in [*named, (shown, None)])
    gate = Gate(token or secrets.token_urlsafe(32), port, known)
    server = _start(gate, listening, label)
    written = f"[{shown}]" if ":" in shown else shown
    return GuardedServer(server, f"http://{written}:{port}/?token={gate.token}", gate)


def _start(gate: Gate, listening: socket.socket, label: str | None) -> viser.ViserServer:
    """A viser server on a socket that listens already, behind the gate."""
    import viser
    import websockets.asyncio.server as websocket_server

    plain_serve: Any = websocket_server.serve
    pages: list[Any] = []  # what viser would answer plain requests with; empty until it serves

    def serve(handler: Any, host: Any = None, port: Any = None, **options: Any) -> Any:
        if port != gate.port or pages:  # somebody else's server, started at this moment
            return plain_serve(handler, host, port, **options)
        pages.append(options.get("process_request"))
        return plain_serve(handler, sock=listening, **{**options, **_behind(gate, pages[0])})

    with _quietly():
        websocket_server.serve = serve  # type: ignore[assignment, misc]
        try:
            server = viser.ViserServer(host="127.0.0.1", port=gate.port, label=label, verbose=False)
        finally:
            websocket_server.serve = plain_serve  # type: ignore[misc]
    missing = _without_tunnel(server) if any(pages) else ["how it serves"]
    if missing:
        with _quietly():
            server.stop()
        listening.close()
        raise _other_viser(", ".join(missing))
    return server


def _behind(gate: Gate, page: Any) -> dict[str, Any]:
    """How websockets serves what is behind the gate; `page` is viser's answer to a plain request."""
    import viser

    scripts, protocol = hashes_of_scripts(), f"viser-v{viser.__version__}"

    def process_request(connection: ServerConnection, request: Request) -> Response | None:
        clients = len(connection.server.connections)
        refused = gate.judge(request, connection.local_address[0], clients, protocol)
        return page(connection, request) if refused is None and page is not None else refused

    def process_response(_: ServerConnection, request: Request, response: Response) -> None:
        for name, value in _HEADERS.items():
            response.headers[name] = value
        host = request.headers["Host"] if response.status_code == 200 else ""  # it was judged
        response.headers["Content-Security-Policy"] = content_policy(scripts, host)

    return {
        "create_connection": careful_connection(),
        "process_request": process_request,
        "process_response": process_response,
        "server_header": None,
        "max_size": _LARGEST,
        "open_timeout": _OPENING,
        "close_timeout": _CLOSING,
        "logger": _LOG,
    }


def _require_viser() -> None:
    """viser, in a version whose inside is known."""
    try:
        import viser
    except ImportError:
        raise missing_extra("viser", "view", "a page in the browser") from None
    import viser._messages as messages

    if not viser.__version__.startswith(f"{_VERSION}."):
        raise _other_viser("its version")
    absent = [name for name in (*sorted(ADMITTED), *TUNNEL) if not hasattr(messages, name)]
    if absent:
        raise _other_viser(f"the messages {', '.join(absent)}")
    if not hashes_of_scripts():
        raise _other_viser("the scripts of its page")


def _other_viser(what: str) -> KinestaticsError:
    """The error for a viser that cannot be guarded."""
    import viser

    message = f"viser {viser.__version__} cannot be guarded; not as expected: {what}"
    return KinestaticsError("KS431", message, f"install one that can: pip install 'viser>={_VERSION},<1.2'")


def _listen(host: str, port: int) -> socket.socket:
    """A socket that listens at host and port."""
    hint = "another port (0 takes a free one), or an address of this machine"
    if not 0 <= port <= _LAST_PORT:
        raise ConfigurationError("KS432", f"cannot listen at {host!r}, port {port}: no such port", hint)
    try:
        where = "127.0.0.1" if host == "localhost" else host
        family, _, _, _, place = socket.getaddrinfo(where, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
        return socket.create_server(place, family=family)
    except OSError as error:
        reason = error.strerror or str(error)
        raise ConfigurationError("KS432", f"cannot listen at {host!r}, port {port}: {reason}", hint) from None


def _without_tunnel(server: viser.ViserServer) -> list[str]:
    """Take viser's public tunnel away, and its button; returns what was not found where it was expected."""
    import viser._messages as messages

    handlers = getattr(getattr(server, "_websock_server", None), "_incoming_handlers", {})
    missing = [f"the handler of {name}" for name in TUNNEL if not handlers.pop(getattr(messages, name), None)]
    server.request_share_url = lambda verbose=True: None  # type: ignore[method-assign]  # noqa: ARG005 - viser's signature
    without_button = functools.partial(server.gui.configure_theme, show_share_button=False)
    without_button()
    server.gui.configure_theme = without_button  # type: ignore[method-assign]
    return missing


@contextlib.contextmanager
def _quietly() -> Iterator[None]:
    """viser does not print: the address it shows lacks the token."""
    import rich

    with _ONE_AT_A_TIME:
        plain = rich.print
        rich.print = lambda *_, **__: None
        try:
            yield
        finally:
            rich.print = plain
