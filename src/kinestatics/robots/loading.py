"""`load`: a robot by catalogue name or from a file. Floor 4."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from hashlib import file_digest
from os import PathLike
from pathlib import Path
from typing import Literal

from ..errors import Place, RobotFileError, UnknownNameError, nearest
from ..model import RobotFile, RobotModel
from .assemble import assemble
from .catalogue import catalogue_names, read_catalogue
from .description import RobotDescription

SUFFIXES = (".urdf", ".xml", ".mjcf", ".xacro")


def load(
    name_or_path: str | PathLike[str],
    base: str | None = None,
    tip: str | None = None,
    joints: Mapping[str, float] | None = None,
    *,
    whole_tree: bool = False,
    package_roots: Sequence[str | PathLike[str]] = (),
    allow_xacro: bool = False,
    max_bytes: int | None = None,
) -> RobotModel:
    """A robot from the catalogue, or from a URDF, MJCF or xacro file.

    The model is the chain from `base` to `tip`. Joints off that path are held, at the values in `joints` or at their home
    or zero position; what hangs on them keeps its place and its mass. No network is used, and meshes are never read.

    Args:
        name_or_path: "ur5e" (see `kinestatics robots`), or a path to .urdf, .xml (MJCF or URDF), .xacro. A catalogue
            name goes before a file of that name, which is reached as "./ur5e".
        base: link to start from; any link may be named. Default the root.
        tip: link whose motion is asked for; any link may be named. Default the only one at the end of a branch.
        joints: joints to hold, {name: value} [rad or m].
        whole_tree: make every moving joint a column of the Jacobian, on the path or not.
        package_roots: folders in which package:// paths may be looked up, besides the model's own.
        allow_xacro: expand a xacro file. It can run code: only for files you trust.
        max_bytes: largest URDF file to read, default 64 MiB.

    Raises:
        UnknownNameError: no such robot, link or joint (with the nearest names).
        RobotFileError: the file is wrong; code, file:line:column and a remedy.
        RobotDefinitionError: KS314, several possible tips and none named.
        MissingExtraError: MJCF without the package mujoco, xacro without xacro.

    Example:
        >>> import kinestatics as ks
        >>> ks.load("ur5e").n
        6
    """
    try:
        path = Path(name_or_path)
    except TypeError:
        message = f"{name_or_path!r} is neither a name nor a path"
        raise UnknownNameError("KS312", message, 'for example ks.load("ur5e") or ks.load("robot.urdf")') from None
    text = str(name_or_path)
    if text == path.stem and text in catalogue_names():
        description = read_catalogue(text)
    elif path.suffix.lower() in SUFFIXES or os.path.isfile(path):
        roots = tuple(Path(root) for root in package_roots)
        file = RobotFile(os.path.abspath(path), tuple(os.path.abspath(root) for root in roots), allow_xacro)
        description = _read_file(path, base, roots, allow_xacro, max_bytes)
        if not description.digest:  # a reader in a process of its own saw the bytes, and not we
            with path.open("rb") as stream:
                description = replace(description, digest=file_digest(stream, "sha256").hexdigest())
        description = replace(description, file=file)
    else:
        hint = nearest(text, catalogue_names())
        raise UnknownNameError(
            "KS312", f"no file and no catalogue robot {text[:200]!r}", f"{hint} (`kinestatics robots` lists all)"
        )
    return assemble(description, base, tip, joints, whole_tree)


def _read_file(
    path: Path, base: str | None, roots: tuple[Path, ...], allow_xacro: bool, max_bytes: int | None
) -> RobotDescription:
    if os.path.isdir(path):
        raise RobotFileError("KS109", "is a folder, not a file", "name the file in it", Place(str(path)))
    if not os.path.isfile(path):  # not Path.is_file: it raises for names that are too long
        beside = (
            sorted(p.name for p in path.parent.glob("*") if p.suffix.lower() in SUFFIXES) if path.parent.is_dir() else []
        )
        raise RobotFileError("KS109", "there is no such file", nearest(path.name, beside), Place(str(path)))
    form = file_format(path)
    if form == "xacro":
        from .urdf import parse_urdf
        from .xacro import expand_xacro

        data = expand_xacro(path, allow_xacro=allow_xacro, package_roots=roots)
        return parse_urdf(data, str(path), package_roots=roots, base=base)
    if form == "mjcf":
        from .mjcf import read_mjcf

        return read_mjcf(path, package_roots=roots, base=base)
    from .urdf import read_urdf
    from .xml import MAX_BYTES

    return read_urdf(path, package_roots=roots, base=base, max_bytes=MAX_BYTES if max_bytes is None else max_bytes)


def file_format(path: Path) -> Literal["urdf", "mjcf", "xacro"]:
    """Which reader a file is for: by its name and, for .xml, by its root element; what is neither, the URDF reader refuses.

    Raises:
        RobotFileError: KS109, it cannot be read.
    """
    suffix = path.suffix.lower()
    if suffix == ".xacro":
        return "xacro"
    if suffix not in (".xml", ".mjcf"):
        return "urdf"
    try:
        with path.open("rb") as file:
            head = file.read(1 << 16)
    except OSError as failure:
        raise RobotFileError("KS109", f"cannot be read: {failure.strerror}", "", Place(str(path))) from None
    return "mjcf" if b"<robot" not in head and (b"<mujoco" in head or suffix == ".mjcf") else "urdf"
