"""A guarded viser server answers its owner and nobody else; that viser alone accepts what is refused here is shown too."""

import contextlib
import re
import socket
import threading
from types import SimpleNamespace

import msgspec.msgpack
import pytest
import viser
import viser._messages as messages
import viser.infra._infra as infra
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.http11 import Request
from websockets.sync.client import connect

import kinestatics.scene.guard as guard_module
from browser import wait_until
from kinestatics.errors import ConfigurationError, KinestaticsError
from kinestatics.scene.guard import guarded_server
from kinestatics.scene.guard_gate import CLIENTS, Gate, is_loopback
from kinestatics.scene.guard_messages import ADMITTED, admissible
from kinestatics.scene.guard_policy import hashes_of_scripts

TOKEN = "the-token-of-the-person-who-started-it"
PROTOCOL = f"viser-v{viser.__version__}"
HANDSHAKE = (
    "Connection: Upgrade",
    "Upgrade: websocket",
    "Sec-WebSocket-Version: 13",
    "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
    f"Sec-WebSocket-Protocol: {PROTOCOL}",
)
TRAVERSALS = (
    "/../../../../etc/passwd",
    "/%2e%2e/%2e%2e/package.json",
    "/..%5c..%5cpackage.json",
    "/....//package.json",
    "//etc/passwd",
)


@pytest.fixture(scope="module")
def owner():
    """A guarded server with a slider and its square; `port`, `cookie` and `host` of its owner."""
    with guarded_server(token=TOKEN) as guarded:
        port = guarded.server.get_port()
        slider = guarded.server.gui.add_slider("joint", -1.0, 1.0, 0.01, 0.0)
        square = guarded.server.gui.add_number("square", 0.0, step=1e-4, disabled=True)
        slider.on_update(lambda _: setattr(square, "value", slider.value**2))
        cookie = f"Cookie: kinestatics-{port}={TOKEN}"
        yield SimpleNamespace(
            guarded=guarded, port=port, cookie=cookie, host=f"Host: 127.0.0.1:{port}", slider=slider, square=square
        )


@pytest.fixture(scope="module")
def stock():
    """Port of a viser server without a guard."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server.get_port()
    server.stop()


def ask(port, *lines, request="GET / HTTP/1.1", host="127.0.0.1"):
    """(status, {header: [values]}, body) of one request, written as it is; status 0 where there is no answer."""
    with socket.create_connection((host, port), timeout=20) as connection:
        connection.sendall("\r\n".join([request, *lines, "", ""]).encode("latin-1"))
        with connection.makefile("rb") as stream:
            status = stream.readline().split()
            if not status:
                return 0, {}, b""
            headers = {}
            while (line := stream.readline().strip()) != b"":
                name, _, value = line.decode().partition(":")
                headers.setdefault(name.lower(), []).append(value.strip())
            return int(status[1]), headers, stream.read(int(headers.get("content-length", ["0"])[0]))


def websocket(owner, **options):
    """A websocket of the owner, as a browser opens it."""
    origin = f"http://127.0.0.1:{owner.port}"
    cookie = {"Cookie": owner.cookie.removeprefix("Cookie: ")}
    address = f"ws://127.0.0.1:{owner.port}"
    return connect(address, origin=origin, subprotocols=[PROTOCOL], additional_headers=cookie, max_size=None, **options)


def read_to_the_end(client):
    """Everything the server says, until it says no more."""
    while True:
        client.recv(timeout=20)


def said(kind, **content):
    """The bytes of a message."""
    return msgspec.msgpack.encode({"type": kind, **content})


CAMERA = {
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (1.0, 1.0, 1.0),
    "fov": 1.0,
    "near": 0.1,
    "far": 10.0,
    "image_height": 10,
    "image_width": 10,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}

# Handshakes ------------------------------------------------------------------------------------------------------------

HOSTILE = {  # Host and Origin lines as another page, another name or another program would send them; the refusal
    "no Origin": (["Host: 127.0.0.1:{port}"], 403),
    "Origin of a stranger": (["Host: 127.0.0.1:{port}", "Origin: https://evil.example"], 403),
    "Origin null": (["Host: 127.0.0.1:{port}", "Origin: null"], 403),
    "Origin of another port": (["Host: 127.0.0.1:{port}", "Origin: http://127.0.0.1:1"], 403),
    "Host of a stranger": (["Host: evil.example:{port}", "Origin: http://evil.example:{port}"], 421),
    "doubled Host": (["Host: 127.0.0.1:{port}", "Host: evil.example:{port}", "Origin: http://127.0.0.1:{port}"], 421),
}
MORE = {
    "Origin of another name of ours": (["Host: 127.0.0.1:{port}", "Origin: http://localhost:{port}"], 403),
    "Origin with our name in front": (["Host: 127.0.0.1:{port}", "Origin: http://127.0.0.1:{port}.evil.example"], 403),
    "Origin by https": (["Host: 127.0.0.1:{port}", "Origin: https://127.0.0.1:{port}"], 403),
    "doubled Origin": (["Host: 127.0.0.1:{port}", *2 * ["Origin: http://127.0.0.1:{port}"]], 400),
    "empty Origin": (["Host: 127.0.0.1:{port}", "Origin:"], 403),
    "Host without port": (["Host: 127.0.0.1", "Origin: http://127.0.0.1"], 421),
    "Host of all addresses": (["Host: 0.0.0.0:{port}", "Origin: http://0.0.0.0:{port}"], 421),
    "Host with a user": (["Host: me@127.0.0.1:{port}", "Origin: http://127.0.0.1:{port}"], 421),
    "no Host": (["Origin: http://127.0.0.1:{port}"], 421),
}


def filled(lines, port):
    return [line.format(port=port) for line in lines]


@pytest.mark.parametrize("with_cookie", [False, True], ids=["stranger", "owner's cookie"])
@pytest.mark.parametrize(("lines", "refusal"), [*HOSTILE.values(), *MORE.values()], ids=[*HOSTILE, *MORE])
def test_hostile_handshakes_are_refused(owner, lines, refusal, with_cookie):
    """Whatever the Host or Origin pretends, the cookie does not help: a browser sends it along for anyone."""
    cookie = [owner.cookie] if with_cookie else []
    assert ask(owner.port, *filled(lines, owner.port), *HANDSHAKE, *cookie)[0] == refusal


@pytest.mark.parametrize("lines", [lines for lines, _ in HOSTILE.values()], ids=HOSTILE)
def test_viser_alone_accepts_them(stock, lines):
    """The same six reach an unguarded server: the test above can fail."""
    assert ask(stock, *filled(lines, stock), *HANDSHAKE)[0] == 101


def test_a_handshake_needs_the_cookie(owner):
    """Host and Origin are right: without cookie, with a wrong one, with the token in the address, no; with it, yes."""
    right = [owner.host, f"Origin: http://127.0.0.1:{owner.port}", *HANDSHAKE]
    assert ask(owner.port, *right)[0] == 403
    assert ask(owner.port, *right, owner.cookie[:-1])[0] == 403
    assert ask(owner.port, *right, request=f"GET /?token={TOKEN} HTTP/1.1")[0] == 403
    assert ask(owner.port, *right, owner.cookie)[0] == 101


@pytest.mark.parametrize("host", ["127.0.0.1:{port}", "localhost:{port}", "LocalHost:{port}"])
def test_loopback_has_two_names(owner, host):
    """By address and by name, in any case; the Origin is the same."""
    host = host.format(port=owner.port)
    assert ask(owner.port, f"Host: {host}", f"Origin: http://{host.lower()}", owner.cookie, *HANDSHAKE)[0] == 101


def test_another_version_is_told_so(owner):
    """A page of another viser is refused before its name of itself is printed anywhere."""
    lines = [owner.host, f"Origin: http://127.0.0.1:{owner.port}", owner.cookie, *HANDSHAKE[:-1]]
    for line in ([], ["Sec-WebSocket-Protocol: viser-v0.0.0"]):
        status, _, body = ask(owner.port, *lines, *line)
        assert (status, body) == (400, b"This page is of another version: load it anew.\n")


def test_sixteen_at_once(owner):
    """So many may look at once, and one more is told to come back; a place that is left is free again."""
    with contextlib.ExitStack() as open_pages:
        for _ in range(CLIENTS):
            open_pages.enter_context(websocket(owner))
        with pytest.raises(InvalidStatus, match="503"):
            websocket(owner)
    wait_until(
        lambda: ask(owner.port, owner.host, f"Origin: http://127.0.0.1:{owner.port}", owner.cookie, *HANDSHAKE)[0] == 101
    )


# Requests for the page -------------------------------------------------------------------------------------------------


def test_the_token_becomes_a_cookie(owner):
    """The address with the token sets a cookie that scripts and other sites cannot use, and leads on without the token."""
    status, headers, body = ask(owner.port, owner.host, request=f"GET /?fixedDpr=0.5&token={TOKEN}&showStats HTTP/1.1")
    assert (status, body) == (303, b"")
    assert headers["location"] == ["/?fixedDpr=0.5&showStats="]
    assert headers["set-cookie"] == [f"kinestatics-{owner.port}={TOKEN}; HttpOnly; SameSite=Strict; Path=/"]
    status, headers, body = ask(owner.port, owner.host, owner.cookie)
    assert status == 200
    assert body.startswith(b"<!doctype html>")
    assert "set-cookie" not in headers


def test_a_link_on_somebodys_page_works(owner):
    """A strict cookie would not follow a redirect that another site began: a page of ours goes on instead."""
    request = f"GET /?token={TOKEN}&darkMode=%22%3E%3Cscript%3E HTTP/1.1"
    status, headers, body = ask(owner.port, owner.host, "Sec-Fetch-Site: cross-site", request=request)
    assert status == 200
    assert headers["set-cookie"]
    assert b'content="0;url=/?darkMode=%22%3E%3Cscript%3E">' in body


@pytest.mark.parametrize(
    "query",
    [
        "",
        "?token=",
        "?token=wrong",
        f"?token={TOKEN[:-1]}",
        f"?token={TOKEN}x",
        f"?token=x&token={TOKEN}",
        f"?Token={TOKEN}",
        "?token=%ff%00",
    ],
)
def test_without_the_token_there_is_no_page(owner, query):
    """Missing, cut, lengthened, doubled: 403, and nothing of it is repeated; viser has not been asked."""
    status, headers, body = ask(owner.port, owner.host, request=f"GET /{query} HTTP/1.1")
    assert status == 403
    assert "set-cookie" not in headers
    assert TOKEN.encode() not in body
    assert b"wrong" not in body


@pytest.mark.parametrize(
    "cookie",
    [
        "",
        "kinestatics-{port}=",
        "kinestatics-{port}=wrong",
        "kinestatics-1={token}",
        "x={token}",
        "kinestatics-{port}=\xff\xfe",
        "=;;,=\x00",
    ],
)
def test_other_cookies_do_not_help(owner, cookie):
    """A wrong value, another port's, another name's, and bytes that are no text."""
    assert ask(owner.port, owner.host, "Cookie: " + cookie.format(port=owner.port, token=TOKEN))[0] in (0, 403)


def test_a_cookie_beside_ours_does_no_harm(owner):
    """Cookies know no ports: a server on another one can put its own of our name before ours."""
    assert (
        ask(owner.port, owner.host, f"Cookie: a=b; kinestatics-{owner.port}=theirs; kinestatics-{owner.port}={TOKEN}")[0]
        == 200
    )


def test_a_wrong_token_is_refused_in_spite_of_the_cookie(owner):
    """The address decides where it says something."""
    assert ask(owner.port, owner.host, owner.cookie, request="GET /?token=wrong HTTP/1.1")[0] == 403


def test_rebinding_is_refused(owner, stock):
    """A name that was made to resolve to this machine is not ours, token and cookie or not; viser alone answers it."""
    for request in ("GET / HTTP/1.1", f"GET /?token={TOKEN} HTTP/1.1"):
        status, headers, body = ask(owner.port, f"Host: evil.example:{owner.port}", owner.cookie, request=request)
        assert (status, body) == (421, b"This server does not go by that name.\n")
        assert "set-cookie" not in headers
    assert ask(stock, f"Host: evil.example:{stock}")[0] == 200


@pytest.mark.parametrize("path", TRAVERSALS)
def test_no_file_but_the_page(owner, path):
    """Neither with the cookie nor with the token in the address is anything beside the page served."""
    for request in (f"GET {path} HTTP/1.1", f"GET {path}?token={TOKEN} HTTP/1.1"):
        status, _, body = ask(owner.port, owner.host, owner.cookie, request=request)
        assert (status, body) == (404, b"")
        assert ask(owner.port, owner.host, request=request)[0] == 403


@pytest.mark.parametrize("method", ["HEAD", "POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "get", "X" * 9000])
def test_other_methods_get_no_answer(owner, method):
    """The connection is closed without a word."""
    assert ask(owner.port, owner.host, owner.cookie, request=f"{method} / HTTP/1.1")[0] == 0


def test_bodies_get_no_answer(owner):
    """Neither does a request that brings something along."""
    for line in ("Content-Length: 4", "Transfer-Encoding: chunked", "Content-Length: x"):
        assert ask(owner.port, owner.host, owner.cookie, line)[0] == 0


@pytest.mark.parametrize(
    "given", ["%0d%0aSet-Cookie:%20a=b", "%0aX:%20y", "%E2%80%A8", "//evil.example", "/\\evil.example", "<script>"]
)
def test_nothing_of_the_address_reaches_a_header(owner, given):
    """What the address carries beside the token comes back in an address of ours, encoded, and nowhere else."""
    status, headers, _ = ask(owner.port, owner.host, request=f"GET /?token={TOKEN}&{given}={given} HTTP/1.1")
    assert status == 303
    assert set(headers) <= {
        *("cache-control", "connection", "content-length", "content-security-policy", "content-type"),
        *("cross-origin-opener-policy", "cross-origin-resource-policy", "date", "location", "referrer-policy"),
        *("set-cookie", "x-content-type-options", "x-frame-options"),
    }
    assert len(headers["set-cookie"]) == 1
    assert re.fullmatch(r"/\?[A-Za-z0-9%=._+-]*", headers["location"][0])


@pytest.mark.parametrize("line", ["Upgrade: websocket", "Cookie: a=b", "Accept-Encoding: gzip", "Origin: http://a"])
def test_doubled_headers_are_refused(owner, line):
    """Where two readers could understand two things, neither does."""
    assert ask(owner.port, owner.host, line, line)[0] == 400


def test_every_answer_carries_the_policy(owner):
    """Page, redirect and refusal: no store, no sniffing, no frame, no referrer, no script but the page's own."""
    for lines, request in (([owner.cookie], "/"), ([], f"/?token={TOKEN}"), ([], "/"), (["Host: x"], "/")):
        _, headers, _ = ask(owner.port, owner.host, *lines, request=f"GET {request} HTTP/1.1")
        assert headers["cache-control"] == ["no-store"]
        assert headers["x-content-type-options"] == ["nosniff"]
        assert headers["x-frame-options"] == ["DENY"]
        assert headers["referrer-policy"] == ["no-referrer"]
        policy = headers["content-security-policy"][0]
        assert "default-src 'none'" in policy
        assert "frame-ancestors 'none'" in policy
        scripts = re.search(r"script-src ([^;]*)", policy)[1]
        assert "'unsafe-inline'" not in scripts
        assert scripts.count("'sha256-") == 2
        assert "server" not in headers


def test_a_slow_stranger_is_let_go(monkeypatch):
    """Who opens a connection and says nothing is not waited for."""
    monkeypatch.setattr(guard_module, "_OPENING", 0.2)
    with (
        guarded_server() as guarded,
        socket.create_connection(("127.0.0.1", guarded.server.get_port()), timeout=20) as silent,
    ):
        silent.sendall(b"GET / HT")
        assert silent.recv(10) == b""


# Names -----------------------------------------------------------------------------------------------------------------


def judged(gate, host, arrived_at):
    request = Request("/", Headers([("Host", host), ("Cookie", f"{gate.cookie}={gate.token}")]))
    refused = gate.judge(request, arrived_at, 0, PROTOCOL)
    return 200 if refused is None else refused.status_code


@pytest.mark.parametrize(
    ("host", "arrived_at", "status"),
    [
        ("192.168.1.5:8000", "192.168.1.5", 200),  # the address by which it was reached
        ("192.168.1.5:8001", "192.168.1.5", 421),
        ("192.168.1.6:8000", "192.168.1.5", 421),
        ("localhost:8000", "192.168.1.5", 421),  # a name of loopback, from outside
        ("localhost:8000", "127.0.0.1", 200),
        ("localhost:8000", "::1", 200),
        ("[::1]:8000", "::1", 200),
        ("[0:0:0:0:0:0:0:1]:8000", "::1", 200),
        ("127.0.0.1:8000", "::ffff:127.0.0.1", 200),
        ("[fe80::1]:8000", "fe80::1%eth0", 200),
        ("cell-3:8000", "192.168.1.5", 200),  # also known as
        ("CELL-3:8000", "192.168.1.5", 200),
        ("proxy.example", "192.168.1.5", 200),  # with a port of its own: 80, which is not written
        ("proxy.example:80", "192.168.1.5", 200),
        ("proxy.example:8000", "192.168.1.5", 421),
        ("evil.example:8000", "192.168.1.5", 421),
        ("0.0.0.0:8000", "127.0.0.1", 421),
        ("127.1:8000", "127.0.0.1", 421),
        ("2130706433:8000", "127.0.0.1", 421),
        ("127.0.0.1:8000 ", "127.0.0.1", 421),
        ("127.0.0.1:8000/x", "127.0.0.1", 421),
        ("", "127.0.0.1", 421),
    ],
)
def test_names_of_a_server(host, arrived_at, status):
    """Its address as it was reached, or a name it was given; nothing is resolved, so no name can be bent to an address."""
    gate = Gate(TOKEN, 8000, frozenset({("cell-3", 8000), ("proxy.example", 80)}))
    assert judged(gate, host, arrived_at) == status


def test_default_port():
    """On port 80 it is left out, by browsers in Host and Origin alike."""
    gate = Gate(TOKEN, 80, frozenset())
    assert judged(gate, "127.0.0.1", "127.0.0.1") == judged(gate, "127.0.0.1:80", "127.0.0.1") == 200
    assert judged(gate, "evil.example", "127.0.0.1") == 421


@pytest.mark.parametrize("host", ["0.0.0.0", "127.0.0.1", "localhost"])
def test_where_it_listens(host):
    """An address that works here is shown; at all addresses, too, only that by which one came is a Host."""
    with guarded_server(host=host, token=TOKEN, also_known_as=["cell-3"]) as guarded:
        port = guarded.server.get_port()
        assert guarded.address == f"http://127.0.0.1:{port}/?token={TOKEN}"
        cookie = f"Cookie: kinestatics-{port}={TOKEN}"
        statuses = {
            name: ask(port, f"Host: {name}:{port}", cookie)[0] for name in ("127.0.0.1", "cell-3", "0.0.0.0", "cell-4")
        }
        assert statuses == {"127.0.0.1": 200, "cell-3": 200, "0.0.0.0": 421, "cell-4": 421}


def test_ipv6_loopback():
    """Its address is written in brackets, and answers."""
    try:
        socket.create_server(("::1", 0), family=socket.AF_INET6).close()
    except OSError:
        pytest.skip("this machine has no IPv6 loopback")
    with guarded_server(host="::1", token=TOKEN) as guarded:
        port = guarded.server.get_port()
        assert guarded.address == f"http://[::1]:{port}/?token={TOKEN}"
        assert ask(port, f"Host: [::1]:{port}", f"Cookie: kinestatics-{port}={TOKEN}", host="::1")[0] == 200


def test_loopback_by_default():
    """Unless asked otherwise, no other machine can reach it."""
    with guarded_server() as guarded:
        assert guarded.address.startswith("http://127.0.0.1:")
        with pytest.raises(OSError):
            socket.create_connection(("127.0.0.2", guarded.server.get_port()), timeout=5)
    assert [is_loopback(host) for host in ("127.0.0.1", "::1", "localhost", "192.168.1.5", "0.0.0.0", "cell-3")] == [
        *(True, True, True),
        *(False, False, False),
    ]


def test_tokens_differ():
    """Each server has its own token, of 256 bits."""
    tokens = set()
    for _ in range(3):
        with guarded_server() as guarded:
            tokens.add(guarded.address.partition("token=")[2])
    assert len(tokens) == 3
    assert all(re.fullmatch(r"[A-Za-z0-9_-]{43}", token) for token in tokens)


@pytest.mark.parametrize(
    ("options", "code", "words"),
    [
        ({"token": "short"}, "KS430", "too easy to guess"),
        ({"token": "a token with spaces in it, long"}, "KS430", "22 letters"),
        ({"host": "no.such.name.invalid"}, "KS432", "cannot listen at 'no.such.name.invalid'"),
        ({"host": "192.0.2.1"}, "KS432", "an address of this machine"),
        ({"port": 70000}, "KS432", "port 70000"),
        ({"host": "a b"}, "KS433", "host 'a b' is neither a name nor an address"),
        ({"host": "http://127.0.0.1"}, "KS433", "neither a name nor an address"),
        ({"host": "cell-3:80"}, "KS433", "neither a name nor an address"),
        ({"also_known_as": ["*"]}, "KS433", "also_known_as '[*]' is neither"),
    ],
)
def test_what_cannot_be_asked(options, code, words):
    """Each mistake has its code and says what to do."""
    with pytest.raises(ConfigurationError, match=words) as caught:
        guarded_server(**options)
    assert caught.value.code == code
    assert caught.value.hint


def test_a_port_in_use_is_said(owner):
    """It does not move to the next port in silence, as viser would."""
    with pytest.raises(ConfigurationError, match=f"port {owner.port}: Address already in use") as caught:
        guarded_server(port=owner.port)
    assert caught.value.code == "KS432"


# Messages --------------------------------------------------------------------------------------------------------------


@contextlib.contextmanager
def public_tunnels():
    """The list of tunnels that were asked for."""
    asked = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("viser._viser.ViserTunnel", lambda *_, **__: asked.append(1) or pytest.fail("a tunnel"))
        yield asked


def test_no_tunnel(owner):
    """A client that asks for the public tunnel gets nothing, keeps its connection, and nothing was opened."""
    with public_tunnels() as asked, websocket(owner) as client:
        client.send(said("ShareUrlRequest"))
        client.send(said("ShareUrlDisconnect"))
        client.send(said("ViewerCameraMessage", **CAMERA))
        move(client, owner, 0.3)
        wait_until(lambda: owner.slider.value == 0.3)  # what was sent before it has been read
        assert owner.guarded.server.request_share_url() is None
        assert not asked
    assert owner.guarded.server._share_tunnel is None


def test_viser_alone_opens_a_tunnel(stock):
    """The same message makes an unguarded server open one: the test above can fail."""
    address = f"ws://127.0.0.1:{stock}"
    with public_tunnels() as asked, connect(address, subprotocols=[PROTOCOL], max_size=None) as client:
        client.send(said("ShareUrlRequest"))
        wait_until(lambda: asked)


def move(client, owner, value):
    client.send(said("GuiUpdateMessage", uuid=owner.slider._impl.uuid, updates={"value": value}))


@pytest.mark.parametrize(
    "raw",
    [
        "text",
        b"",
        b"\xc1",
        b"\x91" * 100_000,  # nested too deeply
        said("NoSuchMessage"),
        msgspec.msgpack.encode([1, 2]),
        msgspec.msgpack.encode({"no": "type"}),
        said("Message"),
        said("RunJavascriptMessage", source="alert(1)"),
        said("GuiUpdateMessage", uuid="x", updates={"update_cb": []}),
        said("GuiUpdateMessage", uuid="x", updates={"value": 1, "label": "other"}),
        said("GuiUpdateMessage", uuid="x", updates={}),
        said("GuiUpdateMessage", uuid="x", updates=3),
        said("GuiUpdateMessage", uuid="x", updates={"value": float("nan")}),
        said("GuiUpdateMessage", uuid="x", updates={"value": [0.0, float("inf")]}),
        said("GuiUpdateMessage", uuid="x", updates={"value": "nan"}),
        said("GuiUpdateMessage", uuid="x", updates={"value": ["1e999"]}),
        said("TransformControlsUpdateMessage", name="/tool", wxyz=(1.0, 0.0, 0.0), position=(0.0, 0.0, 0.0)),
        said("TransformControlsUpdateMessage", name="/tool", wxyz=(1.0, 0.0, 0.0, float("nan")), position=(0.0, 0.0, 0.0)),
        said("ViewerCameraMessage", **{**CAMERA, "position": "abc"}),
        said("ViewerCameraMessage", **{**CAMERA, "more": 1}),
    ],
    ids=range(21),
)
@pytest.mark.filterwarnings("ignore:.viser. .* does not match annotation")
def test_what_no_client_may_say(owner, raw):
    """It is skipped, and the connection lives: the slider still hears its owner."""
    assert admissible(raw) is None
    with websocket(owner) as client:
        client.send(said("ViewerCameraMessage", **CAMERA))
        client.send(raw)
        target = -0.5 if owner.slider.value != -0.5 else 0.5
        move(client, owner, target)
        wait_until(lambda: owner.slider.value == target)


@pytest.mark.parametrize("value", [0.5, 3, True, "a text", "", [1.0, 2.0], ["a"]])
def test_what_a_client_may_say(value):
    """Values of every kind of field pass."""
    assert admissible(said("GuiUpdateMessage", uuid="1e999", updates={"value": value})).updates == {"value": value}


def test_files_of_a_client_are_bounded(monkeypatch):
    """What one client sends as files is kept in memory, so it has an end; the rest is skipped."""
    monkeypatch.setattr("kinestatics.scene.guard_messages._UPLOADED", 100)
    with guarded_server(token=TOKEN) as guarded:
        button, got = guarded.server.gui.add_upload_button("load"), []
        button.on_upload(lambda event: got.append(event.target.value.content))
        here = SimpleNamespace(port=guarded.server.get_port())
        here.cookie = f"Cookie: kinestatics-{here.port}={TOKEN}"
        with websocket(here) as client:
            client.send(said("ViewerCameraMessage", **CAMERA))
            for name, content in (("a", b"a" * 60), ("b", b"b" * 60)):
                upload = {"source_component_uuid": button._impl.uuid, "transfer_uuid": name}
                start = {"filename": "../../x", "mime_type": "", "part_count": 1, "size_bytes": 60}
                client.send(said("FileTransferStartUpload", **upload, **start))
                client.send(said("FileTransferPart", **upload, part_index=0, content=content))
            wait_until(lambda: got)
        wait_until(lambda: not guarded.server._websock_server._live_connections)
        assert got == [b"a" * 60]


def test_large_messages_end_the_connection(monkeypatch):
    """More bytes than any page of ours sends are not read."""
    monkeypatch.setattr(guard_module, "_LARGEST", 1000)
    with guarded_server(token=TOKEN) as guarded:
        here = SimpleNamespace(port=guarded.server.get_port())
        here.cookie = f"Cookie: kinestatics-{here.port}={TOKEN}"
        with websocket(here) as client:
            client.send(b"x" * 1001)
            with pytest.raises(ConnectionClosed, match="1009"):
                read_to_the_end(client)


def test_two_people_look_at_once(owner):
    """What one moves, the other is told."""
    with websocket(owner) as first, websocket(owner) as second:
        for client in (first, second):
            client.send(said("ViewerCameraMessage", **CAMERA))
        target = 0.75 if owner.slider.value != 0.75 else 0.25
        move(first, owner, target)
        wait_until(lambda: tells(second.recv(timeout=20), owner.slider._impl.uuid, target))
        wait_until(lambda: owner.square.value == target**2)


def tells(raw, uuid, value):
    """Whether this window of messages from the server sets that value."""
    import zstandard

    length = int.from_bytes(raw[8:16], "little")
    window = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(raw[16 : 16 + length]))
    return any(message.get("uuid") == uuid and message.get("updates") == {"value": value} for message in window["messages"])


# What of viser's inside is relied on -----------------------------------------------------------------------------------


def test_the_page_is_known():
    """The two scripts of viser's page are found and differ."""
    assert len(set(hashes_of_scripts())) == 2


def test_admitted_messages_are_what_viser_listens_to():
    """Every kind of message for which viser registers a handler is admitted, but the tunnel's."""
    with guarded_server() as guarded:
        heard = {kind.__name__ for kind in guarded.server._websock_server._incoming_handlers}
    assert heard <= ADMITTED
    assert {name for name in ADMITTED if not hasattr(messages, name)} == set()


def broken_version(patch):
    patch.setattr(viser, "__version__", "1.2.0")


def broken_messages(patch):
    patch.delattr(messages, "SceneNodeClickMessage")


def broken_page(patch):
    patch.setattr(guard_module, "hashes_of_scripts", lambda: ())


def broken_serve(patch):
    import websockets

    kept = SimpleNamespace(serve=websockets.asyncio.server.serve)
    names = {name: getattr(websockets, name) for name in ("datastructures", "exceptions")}
    patch.setattr(infra, "websockets", SimpleNamespace(asyncio=SimpleNamespace(server=kept), **names))


def broken_handlers(patch):
    plain = infra.WebsockServer.register_handler

    def other(self, kind, callback):
        return None if kind is messages.ShareUrlRequest else plain(self, kind, callback)

    patch.setattr(infra.WebsockServer, "register_handler", other)


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        (broken_version, "viser 1.2.0 cannot be guarded; not as expected: its version"),
        (broken_messages, "the messages SceneNodeClickMessage"),
        (broken_page, "the scripts of its page"),
        (broken_serve, "how it serves"),
        (broken_handlers, "the handler of ShareUrlRequest"),
    ],
)
def test_another_viser_is_not_started_unguarded(monkeypatch, broken, words):
    """Where viser's inside is not as known, nothing is left running, and the versions that work are named."""
    broken(monkeypatch)
    before = threading.active_count()
    with pytest.raises(KinestaticsError, match=words) as caught:
        guarded_server()
    assert caught.value.code == "KS431"
    assert "viser>=1.1,<1.2" in caught.value.hint
    wait_until(lambda: threading.active_count() <= before)


# The end ---------------------------------------------------------------------------------------------------------------


def test_stop_closes_everything(capfd):
    """Socket, connections and threads are gone, a second stop does no harm, and nothing was printed."""
    before = set(threading.enumerate())
    guarded = guarded_server(token=TOKEN)
    here = SimpleNamespace(port=guarded.server.get_port())
    here.cookie = f"Cookie: kinestatics-{here.port}={TOKEN}"
    with websocket(here) as client:
        client.send(said("ViewerCameraMessage", **CAMERA))
        wait_until(guarded.server.get_clients)
        guarded.stop()
        guarded.stop()
        with pytest.raises(ConnectionClosed):
            read_to_the_end(client)
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", here.port), timeout=5)
    wait_until(lambda: set(threading.enumerate()) <= before)
    with guarded_server(port=here.port) as again:  # the port is free
        assert again.server.get_port() == here.port
    assert capfd.readouterr() == ("", "")


def test_strangers_write_nothing_on_our_terminal(capfd):
    """Broken requests and messages leave no trace there."""
    with guarded_server(token=TOKEN) as guarded:
        port = guarded.server.get_port()
        assert ask(port, request="\x1b[31m BOO HTTP/9")[0] == 0
        assert ask(port, "Host: \x1b[31m")[0] == 0
        assert ask(port, f"Host: 127.0.0.1:{port}", *HANDSHAKE[:-1], "Sec-WebSocket-Protocol: viser-v[red]BOO")[0] == 403
    assert capfd.readouterr() == ("", "")


def test_the_browser_gets_a_ticket(monkeypatch, owner):
    """Other users can read what programs are started with: that address opens the page once, and soon, or not at all."""
    opened = []
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    assert owner.guarded.open_in_browser()
    assert TOKEN not in opened[0]
    assert opened[0].startswith(f"http://127.0.0.1:{owner.port}/?token=")
    request = f"GET /?{opened[0].partition('?')[2]} HTTP/1.1"
    assert ask(owner.port, owner.host, request=request)[0] == 303
    assert ask(owner.port, owner.host, request=request)[0] == 403
    monkeypatch.setattr("kinestatics.scene.guard_gate._TICKET", -1.0)
    owner.guarded.open_in_browser()
    assert ask(owner.port, owner.host, request=f"GET /?{opened[1].partition('?')[2]} HTTP/1.1")[0] == 403
