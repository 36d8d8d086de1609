"""Where a file named inside a robot file may lie: in the model's folder, its package, or a root the user names. Floor 4."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import unquote

from ..errors import Place, RobotFileError


class Search:
    """Looks for files on behalf of one robot file. Nothing is opened.

    Attributes:
        folder: where the robot file lies.
        roots: further folders that may be looked in. Links on the way to either are followed once, here.
    """

    def __init__(self, folder: Path, roots: Sequence[Path] = ()) -> None:
        self.folder = os.path.realpath(folder)
        self.roots = tuple(os.path.realpath(root) for root in roots)
        self._as_given = tuple(os.path.abspath(path) for path in (folder, *roots))
        self._above = (self.folder, *(str(parent) for parent in Path(self.folder).parents), *self.roots)

    def candidates(self, name: str) -> tuple[list[str], list[str]]:
        """Paths at which `name` may be found, and the folders that none of them may leave.

        package://NAME/rest is looked up in every root (as root/NAME/rest, and root/rest where the root is called NAME) and
        in the folders above the model that are called NAME, as ROS does. package:///rest is root/rest.
        """
        allowed = [self.folder, *self.roots]
        scheme, separator, rest = name.partition("://")
        if not separator:
            return [os.path.join(folder, name) for folder in allowed], allowed
        rest = unquote(rest)
        if scheme == "file":
            return [os.path.join(self.folder, rest)], allowed
        package, _, inside = rest.partition("/")
        if scheme != "package":
            return [], allowed
        if not package:  # package:///rest names no package: looked up in the roots alone, for "" is the file system's root
            return [os.path.join(root, inside.lstrip(os.sep)) for root in self.roots], allowed
        named = [folder for folder in self._above if os.path.basename(folder) == package]
        found = [os.path.join(root, package, inside) for root in self.roots] + [os.path.join(f, inside) for f in named]
        return found, allowed + named

    def find(self, name: str, place: Place | None) -> tuple[Path | None, list[Path]]:
        """The file that `name` means, or None, and the paths that were tried.

        Raises:
            RobotFileError: KS111, when the name leads out of the allowed folders (through .., an absolute path or a link).
        """
        tried, allowed = self.candidates(name)
        outside = False
        for path in tried:  # nothing outside is touched, not even to see whether it is there
            if not _is_inside(os.path.normpath(path), (*allowed, *self._as_given)):
                outside = True
            elif os.path.isfile(path):
                if _is_inside(real := os.path.realpath(path), allowed):
                    return Path(real), [Path(path) for path in tried]
                outside = True
        if outside:
            raise RobotFileError(
                "KS111",
                f"path {name!r} leaves the model folder",
                "move the file, or name its folder with package_roots=...",
                place,
            )
        return None, [Path(path) for path in tried]


def _is_inside(path: str, folders: Sequence[str]) -> bool:
    return any(path == folder or path.startswith(folder.rstrip(os.sep) + os.sep) for folder in folders)


def resolve(name: str, folder: Path, roots: Sequence[Path], place: Place | None) -> tuple[Path | None, list[Path]]:
    """`Search(folder, roots).find(name, place)`, for one name.

    Raises:
        RobotFileError: KS111, as there.
    """
    return Search(folder, roots).find(name, place)
