"""What every reader of meshes shares: limits, errors, parts, and the files that may lie beside a mesh. Floor 10."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import Place, RobotFileError
from ..namespaces import Array
from ..robots.paths import Search

MAX_BYTES = 256 << 20
MAX_TRIANGLES = 5_000_000
MAX_NODES = 20_000
"""Nodes of a scene that are drawn, counted as often as they are drawn."""


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles of one colour, as a file holds them: nothing is checked yet.

    Attributes:
        vertices: (k, 3); faces: (m, 3) rows of `vertices`.
        colors: one (3 or 4) for all, or (k, 3 or 4), each from 0 to 255; None where the file gives none.
    """

    vertices: Array
    faces: Array
    colors: Array | None = None


def refused(code: str, message: str, file: Path, hint: str = "") -> RobotFileError:
    """The error for a mesh file."""
    return RobotFileError(code, message, hint, Place(str(file)))


def check_triangles(count: int, file: Path) -> None:
    """Raises RobotFileError (KS442) where there are too many, best before they are made."""
    if count > MAX_TRIANGLES:
        message = f"the mesh has {count} triangles; the limit is {MAX_TRIANGLES}"
        raise refused("KS442", message, file, "reduce it in a mesh editor")


def read_bytes(file: Path) -> bytes:
    """The bytes of a regular file that is not too large.

    Raises:
        RobotFileError: KS440 it cannot be read, KS442 it is too large.
    """
    try:
        if not file.is_file():  # a pipe or a device would never end
            raise refused("KS440", "there is no such mesh file", file)
        size = file.stat().st_size
        if size > MAX_BYTES:
            message = f"the mesh file is {size} bytes; the limit is {MAX_BYTES}"
            raise refused("KS442", message, file, "reduce it in a mesh editor")
        with file.open("rb") as stream:
            return stream.read(MAX_BYTES)
    except (OSError, ValueError) as failure:
        if isinstance(failure, RobotFileError):
            raise
        reason = failure.strerror if isinstance(failure, OSError) else failure
        raise refused("KS440", f"the mesh file cannot be read: {reason}", file) from None


class Beside:
    """Files that a mesh names, such as its materials: looked for in its own folder, and nowhere outside it.

    Attributes:
        file: the mesh.
    """

    def __init__(self, file: Path, folders: Sequence[Path] = ()) -> None:
        self.file = file
        self._search = Search(file.parent, folders)

    def read(self, name: str) -> bytes:
        """The bytes of such a file.

        Raises:
            RobotFileError: KS447 it is not found or lies outside, KS442 it is too large.
        """
        hint = "keep the files of a mesh in one folder"
        try:
            found, _ = self._search.find(name, None)
        except (RobotFileError, ValueError, OSError):
            raise refused("KS447", f"the mesh names {name[:80]!r}, which leaves its folder", self.file, hint) from None
        if found is None:
            raise refused("KS447", f"the mesh names {name[:80]!r}, which is not found in its folder", self.file, hint)
        return read_bytes(found)


def display_color(linear: Array) -> Array:
    """Linear intensities from 0 to 1 as the values that a screen is given (sRGB), from 0 to 1; an opacity is kept."""
    color = np.clip(np.asarray(linear, dtype=float), 0.0, 1.0)
    encoded = np.where(color <= 0.0031308, 12.92 * color, 1.055 * color ** (1 / 2.4) - 0.055)
    opacity = np.arange(color.shape[-1]) >= 3
    return np.where(opacity, color, encoded)
