"""The harness itself: what it says it records and stops, it does."""

import http.server
import threading

import pytest

import browser as harness
from browser import browser_fixture, chromium, page_of_fixture, wait_until  # noqa: F401 - fixtures

PAGE = b"<!doctype html><title>page</title><link rel=icon href=data:,><p id=here>here"


class Answer(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200)
        self.send_header("Content-Type", "text/html")
        self.send_header("Content-Length", str(len(PAGE)))
        self.end_headers()
        self.wfile.write(PAGE)

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def port():
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answer) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True)
        thread.start()
        yield server.server_port
        server.shutdown()
        thread.join()


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_loopback_is_reached_and_quiet(page_of, port, host):
    """A page of this machine opens at the wanted size, and nothing is recorded."""
    tab = page_of(f"http://{host}:{port}/", width=480, height=360)
    assert tab.page.evaluate("[innerWidth, innerHeight]") == [480, 360]
    assert tab.page.locator("#here").inner_text() == "here"
    tab.assert_quiet()


@pytest.mark.parametrize(
    ("script", "record"),
    [
        ("fetch('http://example.org/a?b').catch(() => 0)", "GET http://example.org/a?b"),
        ("fetch('https://example.org/').catch(() => 0)", "CONNECT example.org:443"),
        ("fetch('http://192.0.2.1/').catch(() => 0)", "GET http://192.0.2.1/"),
        ("fetch('http://169.254.1.1/').catch(() => 0)", "GET http://169.254.1.1/"),
        ("void new WebSocket('ws://example.org/s')", "CONNECT example.org:80"),
        ("new Image().src = 'http://example.org/i.png'", "GET http://example.org/i.png"),
        (
            "void new Worker(URL.createObjectURL(new Blob([\"new WebSocket('wss://worker.example/')\"])))",
            "CONNECT worker.example:443",
        ),
    ],
)
def test_what_leaves_loopback_is_recorded_and_refused(page_of, port, script, record):
    """Pages, workers, websockets and bare addresses all pass the proxy."""
    tab = page_of(f"http://127.0.0.1:{port}/")
    tab.page.evaluate(script)
    tab.wait_until(lambda: record in list(tab.left))
    with pytest.raises(AssertionError):
        tab.assert_quiet()


def test_complaints_are_kept(page_of, port):
    """Errors of the console and uncaught exceptions are recorded, each in its list."""
    tab = page_of(f"http://127.0.0.1:{port}/")
    tab.page.evaluate("console.log('fine'); console.error('bad'); setTimeout(() => { throw new Error('uncaught') })")
    tab.wait_until(lambda: tab.page_errors and tab.console_errors)
    assert tab.console_errors == ["bad"]
    assert tab.page_errors == ["uncaught"]


def test_cookies_are_shared_only_beside(page_of, port):
    """Every page has its own cookies, unless it is opened beside another."""
    first = page_of(f"http://127.0.0.1:{port}/")
    first.page.evaluate("document.cookie = 'a=1'")
    assert page_of(f"http://127.0.0.1:{port}/", beside=first).page.evaluate("document.cookie") == "a=1"
    assert page_of(f"http://127.0.0.1:{port}/").page.evaluate("document.cookie") == ""


def test_webgl_is_there(page_of):
    """Software rendering offers WebGL 2."""
    assert page_of().page.evaluate("document.createElement('canvas').getContext('webgl2') !== null")


def test_a_name_can_be_pointed_at_loopback(browser, port):
    """A second browser beside the first resolves a foreign name to this machine; the first does not."""
    with chromium(names=["evil.example"]) as rebound:
        tab = rebound.page_of(f"http://evil.example:{port}/")
        assert tab.page.title() == "page"
        tab.assert_quiet()
    tab = browser.page_of()
    with pytest.raises(Exception, match="ERR_HTTP_RESPONSE_CODE_FAILURE"):
        tab.page.goto(f"http://evil.example:{port}/")
    assert list(tab.left) == [f"GET http://evil.example:{port}/"]


def test_waiting_ends():
    """wait_until tells how long it took, or gives up."""
    answers = iter([False, True])
    assert 0 <= wait_until(lambda: next(answers)) < 5
    with pytest.raises(TimeoutError, match=r"not within 0\.01 s"):
        wait_until(lambda: False, 0.01)


def test_a_missing_browser_is_said(monkeypatch, tmp_path):
    """Skipped with the reason; on continuous integration a failure."""
    monkeypatch.setattr(harness, "EXECUTABLE", tmp_path / "chromium")
    monkeypatch.delenv("KINESTATICS_BROWSER", raising=False)
    with pytest.raises(pytest.skip.Exception, match="chromium does not exist"):
        harness.require_browser()
    monkeypatch.setenv("KINESTATICS_BROWSER", "required")
    with pytest.raises(pytest.fail.Exception, match="chromium does not exist"):
        harness.require_browser()
