"""What a bounded child runs: limits first, then one job on one request, then one answer. Floor 4.

Started by `bounded` as a script of its own in an isolated interpreter; it imports nothing of this package. A job is a module
of this folder with a function `run(request)`. The child cannot write: files have a largest size of 0, and an audit hook
refuses what would start a process, open a connection or change a folder. That bounds an honest parser with a fault. It is no
sandbox against code that is written to get out.
"""

from __future__ import annotations

import importlib.util
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

try:
    import resource
except ImportError:  # not POSIX: the parent's wall time is the only limit
    resource = None  # type: ignore[assignment]

REFUSED = (
    "socket.", "subprocess.", "shutil.", "ftplib.", "http.", "smtplib.", "urllib.",
    "os.system", "os.exec", "os.fork", "os.posix_spawn", "os.spawn", "os.startfile", "os.kill", "os.killpg",
    "os.remove", "os.rename", "os.rmdir", "os.mkdir", "os.link", "os.symlink", "os.chmod", "os.chown", "os.truncate",
    "os.utime", "os.chflags", "os.setxattr", "os.removexattr", "os.mkfifo", "os.mknod", "pty.spawn",
)  # fmt: skip


def set_limits(processor: int, memory: int) -> None:
    """Processor time [s], address space [bytes], and no written files, for the rest of this process's life."""
    if resource is None:
        return
    wanted = {"RLIMIT_CPU": processor, "RLIMIT_AS": memory, "RLIMIT_FSIZE": 0, "RLIMIT_CORE": 0}
    for name, value in wanted.items():
        _, hard = resource.getrlimit(getattr(resource, name))
        bound = value if hard == resource.RLIM_INFINITY else min(value, hard)
        try:
            resource.setrlimit(getattr(resource, name), (bound, bound))
        except (ValueError, OSError):
            continue  # macOS refuses a limit on address space


def forbid_effects() -> None:
    """From here on nothing is started, connected to, moved or opened for writing by way of Python."""
    writing = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if event.startswith(REFUSED) or (event == "open" and isinstance(arguments[2], int) and arguments[2] & writing):
            raise PermissionError(f"{event} is not allowed here")

    sys.addaudithook(hook)


def load_job(name: str) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """The function `run` of the module `name` beside this file; the package itself is not imported."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    run: Callable[[dict[str, Any]], dict[str, Any]] = module.run
    return run


def main() -> None:
    """One request on stdin, one answer on the stdout that this process was born with."""
    job, processor, memory = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    set_limits(processor, memory)
    answer_to = os.dup(1)
    os.dup2(2, 1)  # what a library prints must not mix with the answer
    try:
        request = json.loads(sys.stdin.buffer.read())
        sys.path.append(request["folder"])
        run = load_job(job)  # its libraries may do as they like while they load: no stranger's file is involved yet
        forbid_effects()
        text = json.dumps(run(request))
    except MemoryError:
        text = '{"limit": "memory"}'
    data = text.encode()
    while data:
        data = data[os.write(answer_to, data) :]
    os._exit(0)


if __name__ == "__main__":
    main()
