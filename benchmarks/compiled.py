"""The compiled contestants: the C++ loop over Pinocchio, where its headers and a compiler are there, and the write limit."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

HERE = Path(__file__).parent
EIGEN = ("/usr/include/eigen3", "/usr/local/include/eigen3", "/opt/homebrew/include/eigen3")


def _pointer(array: Any) -> int:
    return int(array.ctypes.data)


def _build(source: str, flags: list[str]) -> ctypes.CDLL | None:
    """A shared library in a temporary folder, or None with the compiler's last words on stderr."""
    compiler = shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        return None
    library = Path(tempfile.mkdtemp()) / f"{source}.so"
    command = [compiler, "-std=c++17", "-O3", "-DNDEBUG", "-fPIC", "-shared", *flags, str(HERE / source), "-o", str(library)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        print(f"{source} does not compile: {done.stderr[-600:]}", file=sys.stderr)
        return None
    return ctypes.CDLL(str(library))


def write_limit() -> ctypes.CDLL | None:
    """The library with `write_limit(pointer, bytes)`."""
    return _build("write_limit.cpp", [])


def pinocchio_library() -> ctypes.CDLL | None:
    """Pinocchio's C++ loop; None where its headers, boost's or Eigen's are missing."""
    prefix = Path(pin.__file__).parents[4] / "include"
    folders = [str(prefix), *EIGEN]
    if not (prefix / "pinocchio").is_dir() or not any((Path(f) / "Eigen").is_dir() for f in EIGEN):
        return None
    boost = ["-DBOOST_MPL_LIMIT_LIST_SIZE=30", "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"]
    library = _build("pinocchio_loop.cpp", [*boost, *(f"-I{folder}" for folder in folders)])
    if library is not None:
        library.loop_new.restype = ctypes.c_void_p
    return library


class PinocchioLoop:
    """One robot in the C++ loop, made from a Pinocchio model of revolute joints about x, y or z."""

    def __init__(self, library: ctypes.CDLL, model: Any, tool: int) -> None:
        joints = range(1, model.njoints)
        axes = "".join(model.joints[i].shortname()[-1] for i in joints)
        if any(not model.joints[i].shortname().startswith("JointModelR") for i in joints) or set(axes) - set("XYZ"):
            raise ValueError("the C++ loop knows revolute joints about x, y and z")
        frame = model.frames[tool]
        numbers = [
            np.array([model.parents[i] for i in joints], dtype=np.intc),
            np.stack([model.jointPlacements[i].homogeneous for i in joints]),
            np.array([model.inertias[i].mass for i in joints]),
            np.stack([model.inertias[i].lever for i in joints]),
            np.stack([model.inertias[i].inertia for i in joints]),
            np.ascontiguousarray(frame.placement.homogeneous),
        ]
        parents, placements, masses, levers, inertias, tool_placement = (np.ascontiguousarray(x) for x in numbers)
        pointers = [ctypes.c_void_p(_pointer(x)) for x in (placements, masses, levers, inertias)]
        self._library = library
        self._handle = ctypes.c_void_p(
            library.loop_new(
                len(axes), ctypes.c_void_p(_pointer(parents)), axes.encode(), *pointers,
                int(frame.parentJoint), ctypes.c_void_p(_pointer(tool_placement)),
            )
        )  # fmt: skip

    def __call__(self, quantity: str, q: Any, out: Any, qd: Any = None) -> None:
        """Fills `out` with "jacobian", "pose", "gravity", "rate", "hessian" or "manipulability" of every row of q."""
        rates = ctypes.c_void_p(_pointer(qd)) if qd is not None else None
        function = getattr(self._library, f"loop_{quantity}")
        function(self._handle, ctypes.c_void_p(_pointer(q)), rates, ctypes.c_long(len(q)), ctypes.c_void_p(_pointer(out)))
