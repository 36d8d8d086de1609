"""`kinestatics explore`: prints its address, serves it, and Ctrl-C ends it well."""

import os
import signal
import socket
import subprocess
import sys
import urllib.parse

import pytest

import kinestatics.explorer
from kinestatics.cli.explore import command

COMMAND = [sys.executable, "-m", "kinestatics", "explore", "planar_2r", "--no-open"]


@pytest.mark.skipif(sys.platform == "win32", reason="Ctrl-C is sent another way there")
def test_it_serves_until_ctrl_c():
    """The printed address answers, and leads on without its token; after Ctrl-C nothing does, and the exit code is 0."""
    with subprocess.Popen(COMMAND, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        try:
            robot, _, address = running.stdout.readline().strip().partition(" at ")
            assert robot == "planar_2r"
            assert running.stdout.readline() == "who has this address can use the page; stop with Ctrl-C\n"
            place = urllib.parse.urlsplit(address)
            with socket.create_connection((place.hostname, place.port), timeout=20) as connection:
                connection.sendall(f"GET /?{place.query} HTTP/1.1\r\nHost: {place.netloc}\r\n\r\n".encode())
                assert connection.recv(12) == b"HTTP/1.1 303"
            running.send_signal(signal.SIGINT)
            out, err = running.communicate(timeout=30)
        finally:
            running.kill()
    assert (running.returncode, out, err) == (0, "", "\nstopped\n")
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((place.hostname, place.port), timeout=5)


class Recorded:
    """Stands for an explorer: what it was started with, and what was asked of it."""

    address = "http://127.0.0.1:8000/?token=t"

    def __init__(self, has_browser=True):
        self.has_browser, self.did, self.options = has_browser, [], None

    def __call__(self, model, q, **options):
        self.options = {"robot": model.name, "q": q.tolist(), **options}
        return self

    def open_in_browser(self):
        self.did.append("opened")
        return self.has_browser

    def wait(self):
        self.did.append("waited")

    def stop(self):
        self.did.append("stopped")


@pytest.fixture
def started(monkeypatch):
    recorded = Recorded()
    monkeypatch.setattr(kinestatics.explorer, "explore", recorded)
    return recorded


def test_options_reach_the_explorer(started, capsys):
    """Posture, payload, mounting, host and port arrive; loopback needs no warning."""
    command("planar_2r", at="0.1,0.2", mount="wall", payload=["2"], host="localhost", port=8000)
    assert started.options["q"] == [0.1, 0.2]
    assert abs(started.options["gravity"]).max() == pytest.approx(9.80665, abs=0.01)
    assert (started.options["host"], started.options["port"], started.options["also_known_as"]) == ("localhost", 8000, ())
    assert started.did == ["opened", "waited", "stopped"]
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(("host", "words"), [("0.0.0.0", "every network"), ("192.168.1.5", "the network of 192.168.1.5")])
def test_beyond_this_machine_is_warned_of(started, capsys, host, words):
    """Who can reach it, and that nothing is encrypted, is said before the address."""
    command("planar_2r", host=host, known_as=["cell-3"], open_page=False)
    error = capsys.readouterr().err
    assert error.startswith("warning: the page can be reached from " + words)
    assert "not encrypted" in error
    assert started.options["also_known_as"] == ["cell-3"]
    assert started.did == ["waited", "stopped"]


def test_without_a_browser_it_says_so(started, capsys):
    """The address is there to be opened by hand."""
    started.has_browser = False
    command("planar_2r")
    assert capsys.readouterr().err == "no browser was found: open the address yourself\n"


def test_a_port_in_use_is_an_error():
    """Its message, on the error stream, and exit code 2."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = str(taken.getsockname()[1])
        asked = [*COMMAND, "--port", port]
        done = subprocess.run(asked, capture_output=True, text=True, check=False, env={**os.environ, "COLUMNS": "80"})
    assert done.returncode == 2
    assert f"error KS432: cannot listen at '127.0.0.1', port {port}: Address already in use" in done.stderr
    assert done.stdout == ""
