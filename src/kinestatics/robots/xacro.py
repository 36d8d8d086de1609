"""xacro: the macro language of URDF. Floor 4.

Expanding a xacro file means evaluating its expressions, and they can be written so that they run any code. So it is refused
unless the user says that the file is trusted. Even then it happens in a bounded child (`bounded`): no environment, limits on
time and memory, files read only in the model's folder, its ROS package and the roots that the user names. That stops the
known tricks and accidents. It is no sandbox: code that is written to get out of one may succeed.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..errors import Place, RobotFileError
from .bounded import Limits, package_folder, run_bounded
from .xml import MAX_BYTES, parse_xml, read_file

LIMITS = Limits(processor=10, wall=12.0, memory=512 << 20)
MARKERS = ("package.xml", "manifest.xml")
CODES = {"outside": "KS111", "package": "KS181", "expansion": "KS194"}
HINTS = {
    "outside": "move the file, or name its folder with package_roots=...",
    "package": "name the folder that holds the package with package_roots=...",
    "expansion": "",
}


def expand_xacro(path: Path, *, allow_xacro: bool, package_roots: Sequence[Path] = ()) -> bytes:
    """The URDF that a xacro file expands to; arguments of the file take their defaults.

    Args:
        path: the file.
        allow_xacro: the file is trusted: its expressions are evaluated, and they can run code.
        package_roots: folders in which $(find NAME) is looked up, and from which files may be included.

    Raises:
        RobotFileError: KS113 without allow_xacro; KS100-KS110 as for any XML file; KS108 a limit; KS111 a file outside
            the folders; KS181 a package that is not found; KS194 whatever else stops xacro.
        MissingExtraError: KS400, without the package xacro.
    """
    place = Place(str(path))
    if not allow_xacro:
        hint = "use allow_xacro=True (in a shell --allow-xacro) for files you trust"
        raise RobotFileError("KS113", "xacro files can run code", hint, place)
    _check(path)
    folder = path.resolve().parent
    packages = _packages_above(folder)
    request = {
        "folder": package_folder("xacro", "xacro", "expanding a xacro file"),
        "path": str(path.resolve()),
        "packages": packages,
        "roots": [str(root.resolve()) for root in package_roots],
        "allowed": [str(folder), *packages.values()],
        "largest": MAX_BYTES,
    }
    answer = run_bounded("xacro_child", request, LIMITS, place)
    if isinstance(answer.get("urdf"), str):
        return str(answer["urdf"]).encode()
    kind = answer.get("kind") if answer.get("kind") in CODES else "expansion"
    raise RobotFileError(CODES[str(kind)], f"xacro: {answer.get('message')}", HINTS[str(kind)], place)


def _check(path: Path) -> None:
    """The file itself, before anything is evaluated: size, encoding, document types, nesting."""
    parse_xml(read_file(path), str(path))


def _packages_above(folder: Path) -> dict[str, str]:
    """ROS packages that the model lies in, {name of the folder: its path}; one is told by its package.xml."""
    found: dict[str, str] = {}
    for above in (folder, *folder.parents):
        if any((above / marker).is_file() for marker in MARKERS):
            found.setdefault(above.name, str(above))
    return found
