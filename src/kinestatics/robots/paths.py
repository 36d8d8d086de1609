"""Where a file named inside a robot file may lie: in the model's folder, its package, or a root the user names. Floor 4."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from urllib.parse import unquote

from ..errors import Place, RobotFileError


def candidates(name: str, folder: Path, roots: Sequence[Path]) -> tuple[list[Path], list[Path]]:
    """Paths at which `name` may be found, and the folders that none of them may leave.

    package://NAME/rest is looked up in every root (as root/NAME/rest, and root/rest where the root is called NAME) and in
    the folders above the model that are called NAME, as ROS does. Nothing is opened.
    """
    allowed = [folder, *roots]
    scheme, separator, rest = name.partition("://")
    if not separator:
        return [folder / name, *(root / name for root in roots)], allowed
    rest = unquote(rest)
    if scheme == "file":
        return [Path(rest)], allowed
    if scheme != "package":
        return [], allowed
    package, _, inside = rest.partition("/")
    found = [root / package / inside for root in roots]
    for above in _named(package, [folder, *folder.parents, *roots]):
        allowed.append(above)
        found.append(above / inside)
    return found, allowed


def _named(name: str, folders: Sequence[Path]) -> Iterator[Path]:
    for folder in folders:
        if folder.name == name:
            yield folder


def resolve(name: str, folder: Path, roots: Sequence[Path], place: Place | None) -> tuple[Path | None, list[Path]]:
    """The file that `name` means, or None, and the paths that were tried.

    Raises:
        RobotFileError: KS111, when the name leads out of the allowed folders (through .., an absolute path or a link).
    """
    folder = folder.resolve()
    tried, allowed = candidates(name, folder, [root.resolve() for root in roots])
    outside = False
    for path in tried:
        real = path.resolve()
        if not any(real.is_relative_to(root) for root in allowed):
            outside = True
            continue
        if real.is_file():
            return real, tried
    if outside:
        raise RobotFileError(
            "KS111",
            f"path {name!r} leaves the model folder",
            "move the file, or name its folder with package_roots=...",
            place,
        )
    return None, tried
