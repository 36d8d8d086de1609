"""The guarded page in a browser: its owner's works, other pages beside it cannot reach it, and no script in a name runs."""

import http.server
import threading
from types import SimpleNamespace

import numpy as np
import pytest
import viser

from browser import chromium
from kinestatics.scene.guard import guarded_server

TOKEN = "the-token-of-the-person-who-started-it"
PROTOCOL = f"viser-v{viser.__version__}"
SHARE_BUTTON = ".tabler-icon-share"
OPEN_SOCKET = """([address, protocol]) => new Promise(done => {
    const socket = new WebSocket(address, protocol);
    socket.onmessage = message => { done('hijacked'); socket.close() };
    socket.onerror = () => done('refused') })"""
OPEN_SOCKET_IN_WORKER = f"""(given) => new Promise(done => {{
    const source = 'onmessage = event => (' + {OPEN_SOCKET!r} + ')(event.data).then(postMessage)';
    const worker = new Worker(URL.createObjectURL(new Blob([source])));
    worker.onmessage = event => done(event.data);
    worker.postMessage(given) }})"""


@pytest.fixture(scope="module")
def owner():
    """A guarded server with a slider and its square."""
    with guarded_server(token=TOKEN) as guarded:
        slider = guarded.server.gui.add_slider("joint", -1.0, 1.0, 0.01, 0.0)
        square = guarded.server.gui.add_number("square", 0.0, step=1e-4, disabled=True)
        slider.on_update(lambda _: setattr(square, "value", slider.value**2))
        yield SimpleNamespace(guarded=guarded, port=guarded.server.get_port(), slider=slider)


@pytest.fixture(scope="module")
def stock():
    """Port of a viser server without a guard."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server.get_port()
    server.stop()


class Stranger(http.server.BaseHTTPRequestHandler):
    """A page of somebody else; it links to whatever its address asks for."""

    def do_GET(self):
        body = f"<!doctype html><link rel=icon href=data:,><a href='{self.path.partition('?to=')[2]}'>go</a>".encode()
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def stranger():
    """Port of somebody else's server on this machine."""
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Stranger) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
        thread.start()
        yield server.server_port
        server.shutdown()
        thread.join()


@pytest.fixture(scope="module")
def rebound():
    """A browser for which evil.example is this machine."""
    with chromium(names=["evil.example"]) as running:
        yield running


@pytest.fixture
def page_of(rebound):
    yield rebound.page_of
    rebound.close_pages()


def ready(tab):
    """The page shows its slider, connected."""
    tab.page.get_by_role("textbox", name="square", exact=True).wait_for(timeout=30_000)


def test_the_owners_page_works(owner, page_of):
    """A typed value reaches the server, whose answer comes; the token is gone from the address; nothing leaves loopback."""
    tab = page_of(owner.guarded.address + "&fixedDpr=0.5", 800, 500)
    ready(tab)
    assert tab.page.url == f"http://127.0.0.1:{owner.port}/?fixedDpr=0.5"
    (cookie,) = tab.page.context.cookies()
    assert (cookie["httpOnly"], cookie["sameSite"], cookie["value"]) == (True, "Strict", TOKEN)
    target = 0.5 if owner.slider.value != 0.5 else 0.9
    box = tab.page.locator("input[type=text]").nth(0)
    box.fill(str(target))
    box.press("Enter")
    square = tab.page.get_by_role("textbox", name="square", exact=True)
    tab.wait_until(lambda: float(square.input_value()) == pytest.approx(target**2))
    assert tab.page.locator(SHARE_BUTTON).count() == 0
    tab.assert_quiet()


@pytest.mark.slow
def test_it_opens_again_without_the_token(owner, page_of):
    """The cookie opens the page when it is loaded anew, and in a second tab; a browser without it sees why it cannot."""
    tab = page_of(owner.guarded.address + "&fixedDpr=0.5", 800, 500)
    tab.page.reload()
    ready(tab)
    ready(page_of(f"http://127.0.0.1:{owner.port}/?fixedDpr=0.5", 800, 500, beside=tab))
    other = page_of(f"http://127.0.0.1:{owner.port}/")
    assert other.page.get_by_text("Open the address that kinestatics printed").count() == 1


def test_other_pages_in_the_same_browser_cannot(owner, stock, stranger, page_of):
    """Beside the owner's page, a page on another port or of another name is refused; viser alone hands it everything."""
    tab = page_of(owner.guarded.address + "&fixedDpr=0.5", 800, 500)
    ready(tab)
    for site in (f"http://127.0.0.1:{stranger}/", f"http://localhost:{stranger}/", f"http://evil.example:{stranger}/"):
        other = page_of(site, beside=tab)
        assert other.page.evaluate(OPEN_SOCKET, [f"ws://127.0.0.1:{owner.port}", PROTOCOL]) == "refused"
    here = page_of(f"http://127.0.0.1:{stranger}/")
    for script in (OPEN_SOCKET, OPEN_SOCKET_IN_WORKER):
        assert here.page.evaluate(script, [f"ws://127.0.0.1:{stock}", PROTOCOL]) == "hijacked"


def test_a_rebound_name_cannot(owner, stock, page_of):
    """A name that resolves to this machine gets 421, of the guarded server; viser alone serves it the page."""
    tab = page_of()
    assert tab.page.goto(f"http://evil.example:{owner.port}/?token={TOKEN}").status == 421
    assert tab.page.goto(f"http://evil.example:{stock}/").status == 200


@pytest.mark.slow
@pytest.mark.parametrize("name", ["127.0.0.1", "evil.example"])
def test_a_link_on_a_strangers_page_opens_it(owner, stranger, page_of, name):
    """A link with the token works wherever it is clicked: in a notebook, in a chat."""
    tab = page_of(f"http://{name}:{stranger}/?to={owner.guarded.address}")
    tab.page.get_by_text("go").click()
    ready(tab)
    assert tab.page.url == f"http://127.0.0.1:{owner.port}/"


def test_the_page_talks_to_its_own_server_only(owner, stock, page_of):
    """viser's page would connect wherever its address says; neither page nor worker may, the policy forbids it."""
    tab = page_of(owner.guarded.address + "&fixedDpr=0.5", 800, 500)
    ready(tab)
    for script in (OPEN_SOCKET, OPEN_SOCKET_IN_WORKER):
        assert tab.page.evaluate(script, [f"ws://127.0.0.1:{stock}", PROTOCOL]) == "refused"


HOSTILE_NAMES = [
    "<img src=x onerror='window.RAN=1'>",
    "<svg onload='window.RAN=1'></svg>",
    "<script>window.RAN=1</script>",
    "<iframe srcdoc='<script>parent.RAN=1</script>'></iframe>",
    "<iframe src='javascript:parent.RAN=1'></iframe>",
    "<a href='javascript:window.RAN=1'>x</a>",
    "[x](javascript:window.RAN=1)",
    "{window.RAN=1}",
    "<object data='javascript:window.RAN=1'></object>",
    "<style>@import 'http://evil.example/'</style>",
    "<details open ontoggle='window.RAN=1'>x</details>",
]


@pytest.fixture(scope="module")
def careless():
    """A page that shows names without escaping them, both ways that viser offers."""
    with guarded_server(token=TOKEN) as guarded:
        for name in HOSTILE_NAMES:
            guarded.server.gui.add_html(name)
            guarded.server.gui.add_markdown("robot " + name)
        guarded.server.gui.add_number("square", 1, disabled=True)
        yield guarded


@pytest.mark.slow
def test_no_script_of_a_name_runs(careless, page_of):
    """The second line of defence: were a name shown unescaped, its script would not run, nor fetch, nor when clicked."""
    tab = page_of(careless.address + "&fixedDpr=0.5", 800, 500)
    ready(tab)
    tab.wait_until(lambda: len([text for text in tab.console_errors if "violates" in text]) >= 5)
    for link in tab.page.get_by_text("x", exact=True).all():
        link.dispatch_event("click")
    tab.page.evaluate("new Promise(done => requestAnimationFrame(() => setTimeout(done)))")
    assert tab.page.evaluate("window.RAN") is None
    assert not list(tab.left)


@pytest.mark.slow
def test_unguarded_the_script_runs(page_of):
    """An unguarded server runs the same name, and draws the button of the public tunnel: the tests above can fail."""
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    server.gui.add_html(HOSTILE_NAMES[0])
    try:
        tab = page_of(f"http://127.0.0.1:{server.get_port()}/?fixedDpr=0.5", 800, 500)
        tab.wait_until(lambda: tab.page.evaluate("window.RAN") == 1)
        assert tab.page.locator(SHARE_BUTTON).count() == 1
    finally:
        server.stop()


@pytest.mark.slow
def test_what_the_explorer_shows_needs_nothing_more(page_of):
    """Meshes, labels, a gizmo, a plot and mathematics in text are shown under the policy without a complaint."""
    with guarded_server(token=TOKEN, label="arm") as guarded:
        gui, scene = guarded.server.gui, guarded.server.scene
        scene.add_icosphere("/ball", radius=0.3)
        scene.add_mesh_simple("/mesh", np.eye(3, dtype=np.float32), np.array([[0, 1, 2]], dtype=np.uint32))
        scene.add_label("/label", "shoulder")
        scene.add_transform_controls("/tool", scale=0.5)
        x = np.arange(5.0)
        series = ({"label": "t"}, {"label": "w", "stroke": "red"})
        gui.add_uplot(data=(x, x**2), series=series, scales={"x": {"time": False}}, title="measure")
        gui.add_markdown("**w** = 0.1")
        gui.add_number("square", 1, disabled=True)
        tab = page_of(guarded.address + "&fixedDpr=0.5", 800, 500)
        ready(tab)
        tab.page.locator("canvas").first.wait_for()
        tab.page.get_by_text("measure").wait_for()
        tab.assert_quiet()
