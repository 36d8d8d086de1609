"""xacro, run on a trusted file: the job of the bounded child of `xacro`. Floor 4; the only module that imports xacro."""

from __future__ import annotations

import importlib
import os
import sys
import sysconfig
from collections.abc import Iterable
from typing import Any

xacro: Any = importlib.import_module("xacro")
substitution_args: Any = importlib.import_module("xacro.substitution_args")
importlib.import_module("yaml")  # xacro imports it when a file asks for it; by then folders are watched


def run(request: dict[str, Any]) -> dict[str, Any]:
    """{"urdf": text}, or {"kind": "outside", "package" or "expansion", "message": sentence}.

    Args:
        request: "path" of the file; "packages", {name: folder}; "roots", folders of packages; "allowed", folders from which
            files may be read; "largest", the length of the text.
    """
    refused: list[str] = []
    missing: list[str] = []
    os.environ.clear()
    substitution_args._eval_find = lambda name: _find(name, request["packages"], request["roots"], missing)
    _watch([*request["allowed"], *request["roots"]], refused)
    try:
        text = xacro.process_file(request["path"]).toxml()
    except BaseException as failure:  # what xacro or an expression raises, SystemExit included
        if _is_memory(failure):
            raise MemoryError from None
        if refused:
            return {"kind": "outside", "message": refused[0]}
        if missing:
            return {"kind": "package", "message": f"package {missing[0]!r} is not found"}
        return {"kind": "expansion", "message": _sentence(failure)}
    if refused:  # an expression may have caught the refusal
        return {"kind": "outside", "message": refused[0]}
    if len(text) > request["largest"]:
        return {"kind": "expansion", "message": f"the result is longer than {request['largest']} characters"}
    return {"urdf": text}


def _is_memory(failure: BaseException) -> bool:
    """Whether memory ran out; xacro wraps what an expression raises."""
    seen: BaseException | None = failure
    while seen is not None and not isinstance(seen, MemoryError):
        seen = getattr(seen, "exc", None) or seen.__cause__ or seen.__context__
    return seen is not None


def _sentence(failure: BaseException) -> str:
    text = str(failure).strip().partition("\n")[0][:500]
    return f"{type(failure).__name__}: {text}" if text else type(failure).__name__


def _find(name: str, packages: dict[str, str], roots: Iterable[str], missing: list[str]) -> str:
    """The folder of a package: one that the model lies in, else one in a root, else a root of that name."""
    if name in packages:
        return packages[name]
    for root in roots:
        if os.path.basename(root) == name:
            return root
        if os.path.basename(name) == name and os.path.isdir(os.path.join(root, name)):
            return os.path.join(root, name)
    missing.append(name)
    raise LookupError(name)


def _watch(folders: Iterable[str], refused: list[str]) -> None:
    """From here on files are read in these folders and in the interpreter's own libraries; others are noted and refused."""
    libraries = [sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")]
    libraries += sys.path  # where imports look; isolated, so that it holds no folder of the model
    allowed = tuple(os.path.join(os.path.realpath(folder), "") for folder in [*folders, *libraries] if folder)
    realpath, join, fsdecode, startswith = os.path.realpath, os.path.join, os.fsdecode, str.startswith

    def hook(event: str, arguments: tuple[Any, ...]) -> None:
        if startswith(event, "ctypes."):  # past it lies everything that the other rules refuse
            raise PermissionError(f"{event} is not allowed here")
        if event in ("open", "os.listdir", "os.scandir", "os.chdir") and not isinstance(arguments[0], int):
            path = fsdecode(arguments[0] or ".")
            if not startswith(join(realpath(path), ""), allowed):
                refused.append(f"path {path!r} leaves the model folder")
                raise PermissionError(refused[-1])

    sys.addaudithook(hook)
