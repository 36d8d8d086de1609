"""STL, OBJ and PLY: formats that hold triangles and little else. Floor 10."""

from __future__ import annotations

import importlib
import io
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import missing_extra
from .mesh_parts import Beside, Part, check_triangles, refused

_HEADER = 84  # bytes: a comment and the number of triangles
_COMMENT = 4096  # bytes in which a text file has come to its first triangle
_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_NUMBER = rb"[ \t]+([-+.\deE]+|[-+]?[nN][aA][nN]|[-+]?[iI][nN][fF]\w*)"
_CORNER = re.compile(rb"(?i:vertex)" + 3 * _NUMBER)


def read_stl(data: bytes, beside: Beside) -> list[Part]:
    """Binary where the length fits the number of triangles, else text; binary files may begin with "solid" too."""
    count = int.from_bytes(data[80:_HEADER], "little") if len(data) >= _HEADER else 0
    if len(data) == _HEADER + count * _TRIANGLE.itemsize:
        check_triangles(count, beside.file)
        corners = np.frombuffer(data, _TRIANGLE, count, _HEADER)["corners"]
    elif b"facet" in data[:_COMMENT].lower():
        check_triangles(data.count(b"outer"), beside.file)
        numbers = [[float(word) for word in corner] for corner in _CORNER.findall(data)]
        if len(numbers) % 3:
            message = f"not a sound STL file: {len(numbers)} corners are no whole number of triangles"
            raise refused("KS443", message, beside.file, "the file seems cut off")
        corners = np.array(numbers).reshape(-1, 3, 3)
    else:
        message = f"not a sound STL file: no text, and {len(data)} bytes for {count} triangles"
        raise refused("KS443", message, beside.file, "the file seems cut off or is none")
    return [Part(corners.reshape(-1, 3), np.arange(3 * len(corners)).reshape(-1, 3))]


class _Materials:
    """What trimesh may open for an OBJ file: its material files, and no picture."""

    def __init__(self, beside: Beside) -> None:
        self._beside = beside

    def get(self, name: str) -> bytes:
        """The bytes of a material file."""
        if not name.lower().endswith(".mtl"):
            raise FileNotFoundError(name)
        return self._beside.read(name)

    __getitem__ = get


def read_obj(data: bytes, beside: Beside) -> list[Part]:
    """Faces of any number of corners, coloured by the materials beside the file."""
    check_triangles(data.count(b"\nf"), beside.file)
    text = data.decode("utf-8", errors="replace").encode()
    loaded = _trimesh("obj").load_obj(io.BytesIO(text), resolver=_Materials(beside))
    return [_part(found) for found in (loaded["geometry"].values() if "geometry" in loaded else [loaded])]


def read_ply(data: bytes, beside: Beside) -> list[Part]:
    """Text or binary, with the colours of its points."""
    header = data[: data.find(b"end_header") + 1]
    counts = [int(count[:12]) for count in re.findall(rb"^element[ \t]+\w+[ \t]+(\d+)", header, re.MULTILINE)]
    if sum(counts) > len(data):
        message = f"not a sound PLY file: it names {sum(counts)} elements and is {len(data)} bytes long"
        raise refused("KS443", message, beside.file, "the file seems cut off or is none")
    check_triangles(max(counts, default=0) // 3, beside.file)
    return [_part(_trimesh("ply").load_ply(io.BytesIO(data), skip_materials=True))]


def _part(found: Mapping[str, Any]) -> Part:
    """What trimesh has read: points and faces, and a colour where there is one."""
    colors = found.get("vertex_colors")
    material = getattr(found.get("visual"), "material", None)
    if colors is None and material is not None:
        colors = getattr(material, "diffuse", None)
    if colors is not None and np.asarray(colors).dtype.kind == "f":
        colors = 255 * np.clip(np.asarray(colors), 0.0, 1.0)
    polygons = np.asarray(found.get("faces", np.zeros((0, 3), dtype=np.int64)))
    fans = [polygons[:, [0, i, i + 1]] for i in range(1, polygons.shape[1] - 1)]
    return Part(np.asarray(found["vertices"]), np.concatenate(fans), colors)


def _trimesh(format_name: str) -> Any:
    """The reader of trimesh for a format."""
    try:
        return importlib.import_module(f"trimesh.exchange.{format_name}")
    except ImportError:
        raise missing_extra("trimesh", "view", "reading this mesh") from None
