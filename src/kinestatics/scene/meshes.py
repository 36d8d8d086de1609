"""`load_mesh`: the triangles in a mesh file, checked. Floor 10.

Mesh files are strangers' files: they are limited in size before they are read and in triangles before these are made; no
archive, address or picture is opened, and nothing outside the mesh's folder. What is wrong is one error with a code, which a
viewer shows as a warning. Meshes are drawn as they are, however fine.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import KinestaticsError
from ..namespaces import Array
from .mesh_collada import read_collada
from .mesh_gltf import read_gltf
from .mesh_parts import Beside, Part, check_triangles, read_bytes, refused
from .mesh_plain import read_obj, read_ply, read_stl

FARTHEST = 1e6
"""No point of a robot lies farther from its link [m]: a wrong unit, and too far for single precision."""
UNCOLORED = (204, 204, 204, 255)

_READERS: dict[str, tuple[str, Callable[[bytes, Beside], list[Part]]]] = {
    ".stl": ("STL", read_stl),
    ".obj": ("OBJ", read_obj),
    ".ply": ("PLY", read_ply),
    ".dae": ("COLLADA", read_collada),
    ".gltf": ("glTF", read_gltf),
    ".glb": ("glTF", read_gltf),
}
_MIXERS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x27D4EB2F165667C5], dtype=np.uint64)
_ARCHIVES = (".zip", ".zae", ".gz", ".bz2", ".xz", ".7z", ".tar", ".3mf", ".3dxml")


@dataclass(frozen=True, eq=False)
class TriangleMesh:
    """Triangles to draw.

    Attributes:
        vertices: (k, 3) float32 [m].
        faces: (m, 3) int32, rows of `vertices`, anticlockwise seen from outside.
        colors: (k, 4) uint8, red, green, blue and opacity of each vertex as a screen is given them, or None.
    """

    vertices: Array
    faces: Array
    colors: Array | None = None

    def __post_init__(self) -> None:
        for array in (self.vertices, self.faces, self.colors):
            if array is not None:
                array.setflags(write=False)

    def by_color(self) -> Iterator[tuple[tuple[int, int, int, int] | None, TriangleMesh]]:
        """The triangles of each colour, those of the first corner's; one mesh and None where there are no colours."""
        if self.colors is None:
            yield None, self
            return
        word = np.ascontiguousarray(self.colors).view(np.uint32).ravel()[self.faces[:, 0]]
        for value in dict.fromkeys(word.tolist()):
            faces = self.faces[word == value]
            used, renumbered = np.unique(faces, return_inverse=True)
            red, green, blue, opacity = self.colors[faces[0, 0]].tolist()
            mesh = TriangleMesh(self.vertices[used], renumbered.reshape(-1, 3).astype(np.int32))
            yield (red, green, blue, opacity), mesh


def load_mesh(
    path: str | PathLike[str], *, folders: Sequence[Path] = (), scale: Sequence[float] = (1.0, 1.0, 1.0)
) -> TriangleMesh:
    """The triangles in an STL, OBJ, PLY, COLLADA or glTF file, in the axes of a URDF <mesh> [m].

    COLLADA is multiplied by its <unit> and its <up_axis> is ignored; glTF is turned from y up to z up; both as RViz does.
    Vertices that are the same are merged.

    Args:
        path: the file.
        folders: where files that it names may lie (materials, buffers), besides its own folder.
        scale: (3) stretches the mesh along its own axes; a mirrored one keeps its faces outwards.

    Raises:
        KinestaticsError: KS440 it cannot be read, KS441 a format that is not read, KS442 too large, KS443 not what its name
            says, KS444 a number that is not finite or too large, KS445 a face without its vertices, KS446 empty, KS447 a
            file beside it is missing or lies outside, KS448 a document type or entity, KS449 a scene without end.
        MissingExtraError: KS400, an OBJ, PLY or COLLADA file without trimesh or pycollada.

    Example:
        >>> import tempfile, pathlib
        >>> from kinestatics.scene.meshes import load_mesh
        >>> text = "solid\\nfacet\\nouter loop\\nvertex 0 0 0\\nvertex 1 0 0\\nvertex 0 1 0\\nendloop\\nendfacet\\nendsolid"
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder) / "triangle.stl"
        ...     _ = path.write_text(text)
        ...     load_mesh(path, scale=(2, 2, 2)).faces
        array([[0, 1, 2]], dtype=int32)
    """
    file = Path(path)
    suffix = file.suffix.lower()
    if suffix not in _READERS:
        archive = "; archives are not opened" if suffix in _ARCHIVES else ""
        message = f"meshes of the format {suffix[:12]!r} are not read{archive}"
        raise refused("KS441", message, file, f"one of {', '.join(_READERS)}")
    name, reader = _READERS[suffix]
    data = read_bytes(file)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the libraries, about numbers that are none: what is left is checked
            parts = reader(data, Beside(file, folders))
        return _joined(parts, np.array(scale, dtype=float), file)
    except KinestaticsError:
        raise
    except MemoryError:
        raise refused("KS442", "the mesh is larger than the memory", file) from None
    except Exception as failure:  # whatever a library makes of a broken file
        reason = str(failure).partition("\n")[0][:120] or type(failure).__name__
        raise refused("KS443", f"not a sound {name} file: {reason}", file) from None


def _joined(parts: Sequence[Part], scale: Array, file: Path) -> TriangleMesh:
    """One mesh of all parts, checked, scaled and merged."""
    check_triangles(sum(len(part.faces) for part in parts), file)
    for part in parts:
        if len(part.faces) and (part.faces.min() < 0 or part.faces.max() >= len(part.vertices)):
            raise refused("KS445", "a face of the mesh has a vertex that does not exist", file)
    parts = [part for part in parts if len(part.faces)]
    if not parts:
        raise refused("KS446", "the mesh holds no triangle", file)
    starts = np.cumsum([0] + [len(part.vertices) for part in parts[:-1]])
    vertices = np.concatenate([np.asarray(part.vertices, dtype=float).reshape(-1, 3) for part in parts])
    faces = np.concatenate([part.faces + start for part, start in zip(parts, starts, strict=True)]).astype(np.int32)
    colors = None
    if any(part.colors is not None for part in parts):
        colors = np.concatenate([_vertex_colors(part) for part in parts])
    with np.errstate(over="ignore", invalid="ignore"):
        vertices = vertices * scale
    used = np.zeros(len(vertices), dtype=bool)
    used[faces.ravel()] = True
    if not np.all(np.abs(vertices[used]) <= FARTHEST):
        message = f"a vertex of the mesh is not finite or farther away than {FARTHEST:g} m"
        raise refused("KS444", message, file, "look for a wrong unit or scale")
    if not np.ptp(vertices[used], axis=0).any():
        raise refused("KS446", "all triangles of the mesh are one point", file)
    if np.prod(np.sign(scale)) < 0:
        faces = faces[:, ::-1]
    return _merged(vertices.astype(np.float32), faces, colors)


def _vertex_colors(part: Part) -> Array:
    """(k, 4) uint8."""
    colors = np.tile(np.array(UNCOLORED, dtype=np.uint8), (len(part.vertices), 1))
    if part.colors is not None:
        given = np.rint(np.clip(np.asarray(part.colors, dtype=float), 0, 255))
        colors[:, 0 : given.shape[-1]] = given
    return colors


def _merged(vertices: Array, faces: Array, colors: Array | None) -> TriangleMesh:
    """Without vertices that are the same, or that no face uses. They are told apart by one number made of all they hold."""
    vertices = vertices + np.float32(0)  # -0 becomes 0: the same place
    columns = [vertices] if colors is None else [vertices, colors]
    rows = np.concatenate([np.ascontiguousarray(column).view(np.uint32) for column in columns], axis=1)
    keys = np.bitwise_xor.reduce(rows.astype(np.uint64) * _MIXERS[: rows.shape[1]], axis=1)
    corners = faces.ravel()
    _, first, which = np.unique(keys[corners], return_index=True, return_inverse=True)
    order = np.argsort(first)  # as the faces meet them
    kept, which = corners[first[order]], np.argsort(order)[which.ravel()]
    if not np.array_equal(rows[kept][which], rows[corners]):  # two numbers met by chance: all stay as they are
        kept, which = corners, np.arange(len(corners))
    faces = which.reshape(-1, 3).astype(np.int32)
    return TriangleMesh(vertices[kept], faces, None if colors is None else colors[kept])
