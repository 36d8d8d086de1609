"""glTF 2.0 (.gltf, .glb). Floor 10.

Its y axis points up; a mesh of a robot is turned so that z does, as RViz (since 2025), Drake and Blender do. No picture is
opened and nothing compressed: Draco and meshopt are refused.
"""

from __future__ import annotations

import base64
import binascii
import json
from typing import Any

import numpy as np

from ..errors import KinestaticsError
from ..namespaces import Array
from ..spatial import quaternion_to_rotation
from .mesh_parts import MAX_BYTES, MAX_NODES, MAX_TRIANGLES, Beside, Part, check_triangles, display_color, refused

_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC3": 3}
_HARMLESS = ("KHR_materials_", "KHR_texture_", "KHR_lights_", "KHR_mesh_quantization")
_TRIANGLES = 4
_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


def read_gltf(data: bytes, beside: Beside) -> list[Part]:
    """The triangles of the scene, with the base colours of their materials."""
    return _Document(data, beside).parts()


class _Document:
    """The JSON of a file and its bytes; every number in it is checked before it is used."""

    def __init__(self, data: bytes, beside: Beside) -> None:
        self.beside = beside
        text, self.binary = _chunks(data, beside)
        try:
            tree = json.loads(text)
        except (ValueError, RecursionError):
            raise self.unsound("its JSON cannot be read") from None
        if not isinstance(tree, dict):
            raise self.unsound("its JSON is no object")
        self.tree: dict[str, Any] = tree
        required = [name for name in tree.get("extensionsRequired", []) if not str(name).startswith(_HARMLESS)]
        if required:
            message = f"the mesh needs {str(required[0])[:60]!r}, which is not read"
            raise refused("KS441", message, beside.file, "export it without compression")
        self.buffers: dict[int, bytes] = {}

    def unsound(self, reason: str) -> KinestaticsError:
        return refused("KS443", f"not a sound glTF file: {reason}", self.beside.file)

    def entry(self, what: str, index: Any) -> dict[str, Any]:
        """One entry of a list, by a whole number that the file gives."""
        entries = self.tree.get(what)
        if not isinstance(entries, list) or not isinstance(index, int) or not 0 <= index < len(entries):
            raise self.unsound(f"there is no {what}[{str(index)[:20]}]")
        if not isinstance(entries[index], dict):
            raise self.unsound(f"{what}[{index}] is no object")
        return dict(entries[index])

    def parts(self) -> list[Part]:
        """Every mesh that is drawn, where it is drawn. Nodes are a tree: none is reached twice."""
        roots = self.entry("scenes", self.tree.get("scene", 0)).get("nodes", [])
        stack = [(index, np.eye(4)) for index in reversed(roots)]
        seen: set[Any] = set()
        found: list[Part] = []
        triangles = 0
        while stack:
            index, T_parent = stack.pop()
            if index in seen or len(seen) > MAX_NODES:
                reason = "in a loop or twice" if index in seen else f"with more than {MAX_NODES} nodes"
                raise refused("KS449", f"the scene of the mesh is drawn {reason}", self.beside.file)
            seen.add(index)
            node = self.entry("nodes", index)
            T = T_parent @ self.matrix(node)
            stack.extend((child, T) for child in reversed(node.get("children", [])))
            for part in self.mesh(node["mesh"]) if "mesh" in node else ():
                triangles += len(part.faces)
                check_triangles(triangles, self.beside.file)
                vertices = (part.vertices @ T[:3, :3].T + T[:3, 3]) @ _Z_UP.T
                faces = part.faces if np.linalg.det(T[:3, :3]) > 0 else part.faces[:, ::-1]
                found.append(Part(vertices, faces, part.colors))
        return found

    def matrix(self, node: dict[str, Any]) -> Array:
        """(4, 4) of a node, given column by column or as translation, rotation (x, y, z, w) and scale."""
        if "matrix" in node:
            return np.array(node["matrix"], dtype=float).reshape(4, 4).T
        T = np.eye(4)
        x, y, z, w = (float(number) for number in node.get("rotation", (0, 0, 0, 1)))
        T[:3, :3] = quaternion_to_rotation(w, x, y, z) * np.array(node.get("scale", (1, 1, 1)), dtype=float)
        T[:3, 3] = node.get("translation", (0, 0, 0))
        return T

    def mesh(self, index: Any) -> list[Part]:
        """The triangles of a mesh; lines and points are left out."""
        found = []
        for primitive in self.entry("meshes", index).get("primitives", []):
            mode = primitive.get("mode", _TRIANGLES)
            if mode in (5, 6):
                raise refused(
                    "KS441", "strips and fans of triangles are not read", self.beside.file, "export plain triangles"
                )
            if mode != _TRIANGLES or "POSITION" not in primitive.get("attributes", {}):
                continue
            vertices = self.array(primitive["attributes"]["POSITION"], "VEC3").astype(float)
            count = np.arange(len(vertices)) if "indices" not in primitive else self.array(primitive["indices"], "SCALAR")
            if len(count) % 3:
                raise self.unsound(f"{len(count)} corners are no whole number of triangles")
            found.append(Part(vertices, count.reshape(-1, 3).astype(np.int64), self.color(primitive)))
        return found

    def color(self, primitive: dict[str, Any]) -> Array | None:
        """The base colour of a primitive's material."""
        if "material" not in primitive:
            return None
        surface = self.entry("materials", primitive["material"]).get("pbrMetallicRoughness", {})
        factor = surface.get("baseColorFactor")
        if factor is None:
            return None
        return 255 * display_color(np.array(factor, dtype=float).reshape(4))

    def array(self, index: Any, kind: str) -> Array:
        """The numbers of an accessor, (count) or (count, 3)."""
        accessor = self.entry("accessors", index)
        count, component = accessor.get("count"), accessor.get("componentType")
        if accessor.get("type") != kind or component not in _COMPONENTS or "sparse" in accessor:
            raise self.unsound(f"accessor {index} is of a kind that is not read")
        if not isinstance(count, int) or not 0 <= count <= 3 * MAX_TRIANGLES:
            raise refused("KS442", f"the mesh has {str(count)[:20]} points or corners", self.beside.file)
        dtype, width = np.dtype(_COMPONENTS[component]), _WIDTHS[kind]
        view = self.entry("bufferViews", accessor.get("bufferView"))
        offset = _whole(view.get("byteOffset", 0)) + _whole(accessor.get("byteOffset", 0))
        stride = _whole(view.get("byteStride", 0)) or width * dtype.itemsize
        data = self.buffer(view.get("buffer", 0))
        if stride < width * dtype.itemsize or (count and offset + (count - 1) * stride + width * dtype.itemsize > len(data)):
            raise refused("KS445", f"accessor {index} reaches beyond its {len(data)} bytes", self.beside.file)
        values = np.ndarray((count, width), dtype, data, offset, (stride, dtype.itemsize)).copy()
        if accessor.get("normalized") and dtype.kind != "f":
            values = values / np.iinfo(dtype).max
        return values if width > 1 else values.ravel()

    def buffer(self, index: Any) -> bytes:
        """The bytes of a buffer: in the file itself, as text in its JSON, or in a file beside it."""
        if index not in self.buffers:
            uri = self.entry("buffers", index).get("uri")
            self.buffers[index] = self.binary if uri is None else self.outside(str(uri))
            if sum(map(len, self.buffers.values())) > MAX_BYTES:
                raise refused("KS442", f"the buffers of the mesh are larger than {MAX_BYTES} bytes", self.beside.file)
        return self.buffers[index]

    def outside(self, uri: str) -> bytes:
        """What a uri means."""
        if not uri.startswith("data:"):
            return self.beside.read(uri)
        try:
            return base64.b64decode(uri.partition(",")[2], validate=True)
        except (ValueError, binascii.Error):
            raise self.unsound("a buffer written in it is no base64") from None


def _whole(number: Any) -> int:
    """A whole number from 0 on; else a KeyError's kin, which the door turns into an error."""
    if not isinstance(number, int) or number < 0:
        raise ValueError(f"{str(number)[:20]!r} is no whole number")
    return number


def _chunks(data: bytes, beside: Beside) -> tuple[bytes, bytes]:
    """The JSON and the bytes behind it; a .gltf file is all JSON."""
    if data[:4] != b"glTF":
        return data, b""
    found: dict[bytes, bytes] = {}
    start = 12
    while start + 8 <= len(data):
        length = int.from_bytes(data[start : start + 4], "little")
        if start + 8 + length > len(data):
            raise refused("KS443", "not a sound glTF file: it is cut off", beside.file)
        found.setdefault(data[start + 4 : start + 8], data[start + 8 : start + 8 + length])
        start += 8 + length
    return found.get(b"JSON", b""), found.get(b"BIN\x00", b"")
