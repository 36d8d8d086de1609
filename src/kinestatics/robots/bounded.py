"""A job done on a stranger's file in a child process with limits on processor time, memory and wall time. Floor 4.

MuJoCo hangs or grows on hostile files, and xacro can run code; neither is ever imported into the user's process. The child
is an isolated interpreter with next to no environment. It sets its own limits before it reads anything, answers in JSON, and
cannot write a file (`bounded_child`). Limits on processor time need POSIX and those on memory Linux; elsewhere the wall time
alone bounds it.
"""

from __future__ import annotations

import contextlib
import importlib.util
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from ..errors import Place, RobotFileError, missing_extra
from .xml import MAX_BYTES

_LOADER_SETTINGS = ("LD_LIBRARY_PATH", "DYLD_LIBRARY_PATH", "SYSTEMROOT")  # without these some interpreters cannot start


@dataclass(frozen=True)
class Limits:
    """What a child may use.

    Attributes:
        processor: processor time [s]; wall: time until it is ended [s].
        memory: address space [bytes]; output: longest answer [bytes].
    """

    processor: int
    wall: float
    memory: int
    output: int = 2 * MAX_BYTES


def package_folder(package: str, extra: str, purpose: str) -> str:
    """The folder in which an optional package is installed; the package is looked for and not imported.

    Raises:
        MissingExtraError: KS400.
    """
    try:
        found = importlib.util.find_spec(package)
    except (ImportError, ValueError):
        found = None
    if found is None or found.origin is None:
        raise missing_extra(package, extra, purpose)
    return str(Path(found.origin).resolve().parent.parent)


def run_bounded(job: str, request: Mapping[str, object], limits: Limits, place: Place) -> dict[str, Any]:
    """The answer of the module `job` of this folder to a request, both as JSON.

    Args:
        job: name of the module that the child runs.
        request: what it is asked.
        limits: what it may use.
        place: the file that it is asked about, for messages.

    Raises:
        RobotFileError: KS108, a limit was reached; KS192, the child ended without an answer.
    """
    data = json.dumps(request).encode()
    script = Path(__file__).with_name("bounded_child.py")
    process = subprocess.Popen(
        [sys.executable, "-I", "-B", "-X", "utf8", str(script), job, str(limits.processor), str(limits.memory)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=_environment(),
        cwd=Path(sys.executable).anchor,
        start_new_session=True,
    )
    try:
        output = _talk(process, data, limits, place)
    finally:
        _end(process)
    return _answer(output, process.returncode, limits, place)


def _environment() -> dict[str, str]:
    kept = {name: os.environ[name] for name in _LOADER_SETTINGS if name in os.environ}
    return kept | {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MUJOCO_GL": "disable"}


def _talk(process: subprocess.Popen[bytes], data: bytes, limits: Limits, place: Place) -> bytes:
    """Writes the request and reads the answer, in threads: a child may stop doing either."""
    assert process.stdin is not None
    assert process.stdout is not None
    received: list[bytes] = []
    writer = threading.Thread(target=_write, args=(process.stdin, data), daemon=True)
    reader = threading.Thread(target=_read, args=(process.stdout, limits.output + 1, received), daemon=True)
    writer.start()
    reader.start()
    reader.join(limits.wall)
    too_slow = reader.is_alive()
    _end(process, patience=0.0 if too_slow else 0.5)
    reader.join(1.0)
    writer.join(1.0)
    for thread, stream in ((reader, process.stdout), (writer, process.stdin)):
        if not thread.is_alive():  # else a process that left the group still holds the pipe; closing would wait for it
            _close(stream)
    if too_slow:
        raise _over(f"{limits.wall:g} s of wall time", place)
    if len(received[0]) > limits.output:
        raise _over(f"{limits.output} bytes of answer", place)
    return received[0]


def _write(stream: IO[bytes], data: bytes) -> None:
    try:
        stream.write(data)
        stream.close()
    except (OSError, ValueError):
        return  # the child has ended; its return code says why


def _read(stream: IO[bytes], size: int, received: list[bytes]) -> None:
    received.append(stream.read(size))


def _close(stream: IO[bytes]) -> None:
    try:
        stream.close()
    except OSError:
        return  # what was not yet written to a child that has ended


def _end(process: subprocess.Popen[bytes], patience: float = 0.0) -> None:
    """Waits a moment [s] for a child that has answered, then ends it with whatever it started."""
    if process.returncode is None:
        try:
            process.wait(patience)
        except subprocess.TimeoutExpired:
            process.kill()
    if os.name == "posix":
        with contextlib.suppress(ProcessLookupError, PermissionError):  # the usual case: nothing is left of the group
            os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def _answer(output: bytes, code: int, limits: Limits, place: Place) -> dict[str, Any]:
    try:
        answer = json.loads(output)
    except ValueError:
        answer = None
    if isinstance(answer, dict):
        if answer.get("limit") == "memory":
            raise _over(f"{limits.memory >> 20} MB of memory", place)
        return answer
    if os.name == "posix" and code in (-signal.SIGXCPU, -signal.SIGKILL):
        raise _over(f"{limits.processor} s of processor time", place)
    how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
    raise RobotFileError("KS192", f"the process that reads the file ended without an answer ({how})", "", place)


def _over(limit: str, place: Place) -> RobotFileError:
    hint = "make the model smaller: fewer replicated, generated or nested parts"
    return RobotFileError("KS108", f"reading this file took more than the limit of {limit}", hint, place)
