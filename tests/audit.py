"""What is opened while something runs: an audit hook cannot be taken off, so there is one, and it listens when asked to."""

import contextlib
import os
import sys
import sysconfig

_LISTENING = []


def _hook(event, arguments):
    if _LISTENING and event in ("open", "os.listdir", "os.scandir", "socket.connect", "subprocess.Popen"):
        _LISTENING[-1].append((event, arguments[0]))


sys.addaudithook(_hook)


@contextlib.contextmanager
def opened():
    """The real paths that are opened inside the block, but for Python's own; a process or a connection is (event, what)."""
    events, found = [], []
    _LISTENING.append(events)
    try:
        yield found
    finally:
        _LISTENING.remove(events)
    own = [os.path.realpath(sysconfig.get_path(name)) for name in ("stdlib", "purelib", "platlib")]
    data = [os.path.join(folder, "cmeel.prefix") for folder in own]
    for event, what in events:
        if event != "open":
            found.append((event, what))
        elif isinstance(what, str | bytes | os.PathLike):
            path = os.path.realpath(os.fsdecode(what))
            if not path.startswith(tuple(own)) or path.startswith(tuple(data)):
                found.append(path)
