"""One headless Chromium for the tests of pages: software WebGL, nothing leaves loopback, every complaint is kept.

    from browser import browser_fixture, page_of_fixture, wait_until  # noqa: F401 - fixtures

    def test_title(page_of):                        # the fixtures are called `browser` and `page_of`
        tab = page_of("http://127.0.0.1:8000/", width=800, height=600)
        tab.wait_until(lambda: tab.page.title() == "panda")
        tab.assert_quiet()                          # no error on the console or in a script, nothing left loopback

What is not loopback goes to a proxy of our own, which writes it down and refuses it: pages, workers and websockets alike.
Without playwright or Chromium the tests are skipped; KINESTATICS_BROWSER=required, for continuous integration, fails them.
While a browser runs, playwright's event loop owns this thread: use threads or blocking clients beside it, not asyncio.run.
"""

import contextlib
import dataclasses
import importlib.util
import os
import socketserver
import threading
import time
from pathlib import Path

import pytest

EXECUTABLE = Path("/usr/bin/chromium")  # the distribution's package: `playwright install` is not needed
LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
FLAGS = (
    "--no-sandbox",  # the tests may run as the superuser
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-domain-reliability",
    "--disable-sync",
    "--no-first-run",
    "--no-pings",
    "--gaia-url=http://127.0.0.1:9",  # what it asks even so, it asks where nobody listens: accounts,
    "--component-updater=url-source=http://127.0.0.1:9/",  # parts of itself,
    "--apps-gallery-update-url=http://127.0.0.1:9/",  # extensions,
    "--autofill-server-url=http://127.0.0.1:9/",  # what the fields of a form mean
    "--force-webrtc-ip-handling-policy=disable_non_proxied_udp",
)
_running = []  # the one playwright of this thread: a second one cannot start beside it


def wait_until(test, seconds=20.0, pause=lambda: time.sleep(0.02)):
    """Seconds until `test()` holds; TimeoutError if it does not within `seconds`."""
    began = time.perf_counter()
    while not test():
        if time.perf_counter() - began > seconds:
            raise TimeoutError(f"not within {seconds} s")
        pause()
    return time.perf_counter() - began


@dataclasses.dataclass(frozen=True)
class Tab:
    """A page with what it complained about: `page` is playwright's, the lists grow while it lives."""

    page: object
    console_errors: list  # texts of console.error, among them refused requests
    page_errors: list  # exceptions no script caught
    left: list  # what the browser sent beyond loopback since the page opened: "GET http://...", "CONNECT host:port"

    def wait_until(self, test, seconds=20.0):
        """`wait_until`, while events of the page keep coming in."""
        return wait_until(test, seconds, lambda: self.page.wait_for_timeout(20))

    def assert_quiet(self):
        """Nothing went wrong in the page, and nothing tried to leave this machine."""
        self.page.wait_for_timeout(0)  # events that wait are delivered
        assert not self.console_errors
        assert not self.page_errors
        assert not list(self.left)


class Browser:
    """A running Chromium; `page_of` opens pages, each in a context (cookies, storage) of its own."""

    def __init__(self, chromium, left):
        self._chromium, self._left, self._contexts = chromium, left, []

    def page_of(self, url=None, width=1000, height=700, *, beside=None, **options):
        """A Tab at `url`. `beside` (a Tab) shares that one's cookies; other options go to playwright's new_context."""
        if beside is None:
            context = self._chromium.new_context(viewport={"width": width, "height": height}, **options)
            self._contexts.append(context)
        else:
            context = beside.page.context
        page = context.new_page()
        page.set_viewport_size({"width": width, "height": height})
        tab = Tab(page, [], [], _Since(self._left))
        page.on("console", lambda message: message.type == "error" and tab.console_errors.append(message.text))
        page.on("pageerror", lambda error: tab.page_errors.append(str(error)))
        if url is not None:
            page.goto(str(url))
        return tab

    def close_pages(self):
        """Close every page, and forget their cookies."""
        while self._contexts:
            self._contexts.pop().close()


@contextlib.contextmanager
def chromium(names=(), flags=()):
    """A Browser. `names` are resolved to 127.0.0.1, as someone who owns a domain could arrange it."""
    require_browser()
    with _recording_proxy() as (port, left), _playwright() as playwright:
        arguments = [
            *FLAGS,
            f"--proxy-server=http://127.0.0.1:{port}",
            "--proxy-bypass-list=" + ";".join(("<-loopback>", *LOOPBACK, *names)),
            *([f"--host-resolver-rules={','.join(f'MAP {name} 127.0.0.1' for name in names)}"] if names else []),
            *flags,
        ]
        started = playwright.chromium.launch(executable_path=str(EXECUTABLE), headless=True, args=arguments)
        browser = Browser(started, left)
        try:
            yield browser
        finally:
            browser.close_pages()
            started.close()


@pytest.fixture(name="browser", scope="module")
def browser_fixture():
    """One Chromium for the tests of a module."""
    with chromium() as running:
        yield running


@pytest.fixture(name="page_of")
def page_of_fixture(browser):
    """`Browser.page_of`, whose pages are closed when the test ends."""
    yield browser.page_of
    browser.close_pages()


def require_browser():
    """Skip the test where no browser can be driven; fail it where KINESTATICS_BROWSER=required."""
    missing = [] if importlib.util.find_spec("playwright") else ["the Python package playwright is not installed"]
    if not EXECUTABLE.exists():
        missing.append(f"{EXECUTABLE} does not exist (Debian: apt-get install chromium)")
    if missing:
        reason = "no browser to test pages in: " + ", ".join(missing)
        required = os.environ.get("KINESTATICS_BROWSER") == "required"
        pytest.fail(reason) if required else pytest.skip(reason)


@contextlib.contextmanager
def _playwright():
    """The playwright of this thread, started if none runs yet."""
    if _running:
        yield _running[0]
        return
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        _running.append(playwright)
        try:
            yield playwright
        finally:
            _running.clear()


class _Since:
    """The entries of a growing list from now on."""

    def __init__(self, entries):
        self._entries, self._begin = entries, len(entries)

    def __iter__(self):
        return iter(self._entries[self._begin :])

    def __len__(self):
        return len(self._entries) - self._begin

    def __repr__(self):
        return repr(list(self))


@contextlib.contextmanager
def _recording_proxy():
    """(port, list): an HTTP proxy that writes down what it is asked for, and refuses it."""
    left = []

    class Refuse(socketserver.StreamRequestHandler):
        timeout = 10

        def handle(self):
            with contextlib.suppress(OSError):
                line = self.rfile.readline(65536).decode("latin-1").strip()
                if line:
                    left.append(line.rpartition(" ")[0])
                while self.rfile.readline(65536) not in (b"\r\n", b""):
                    pass
                self.wfile.write(b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")

    class Proxy(socketserver.ThreadingTCPServer):
        daemon_threads = True

    with Proxy(("127.0.0.1", 0), Refuse) as proxy:
        thread = threading.Thread(target=proxy.serve_forever, args=(0.05,), daemon=True)
        thread.start()
        try:
            yield proxy.server_address[1], left
        finally:
            proxy.shutdown()
            thread.join()
