"""COLLADA (.dae), as URDF tools read it. Floor 10.

Lengths are multiplied by the file's <unit>, and <up_axis> is ignored: so do RViz, MoveIt and Gazebo, and robots are made to
look right there. The axes of the file are those of the <visual>.
"""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ..errors import RobotFileError, missing_extra
from ..namespaces import Array
from ..robots.xml import parse_xml
from .mesh_parts import MAX_BYTES, MAX_NODES, Beside, Part, check_triangles, refused


def read_collada(data: bytes, beside: Beside) -> list[Part]:
    """The triangles of the scene, with the diffuse colours of its materials; pictures are not opened."""
    _check(data, beside)
    try:
        import collada
    except ImportError:
        raise missing_extra("pycollada", "view", "reading a COLLADA mesh") from None
    document = collada.Collada(io.BytesIO(data), ignore=[collada.common.DaeError])
    if document.errors:  # a part whose material is broken is not there; it is read again without it
        data = _without_broken_materials(data, {material.id for material in document.materials})
        document = collada.Collada(io.BytesIO(data), ignore=[collada.common.DaeError])
    unit = document.assetInfo.unitmeter
    unit = 1.0 if unit is None else float(unit)
    if document.scene is None:
        return []
    found = []
    triangles = 0
    for geometry, T in _geometries(document.scene.nodes, beside):
        for part in _parts(geometry, beside):
            triangles += len(part.faces)
            check_triangles(triangles, beside.file)
            vertices = unit * (part.vertices @ T[:3, :3].T + T[:3, 3])
            faces = part.faces if np.linalg.det(T[:3, :3]) > 0 else part.faces[:, ::-1]
            found.append(Part(vertices, faces, part.colors))
    if not found and document.errors:
        reason = str(document.errors[0]).partition("\n")[0][:120]
        raise refused("KS443", f"not a sound COLLADA file: {reason}", beside.file)
    return found


def _check(data: bytes, beside: Beside) -> None:
    """No archive, no document type and no entity, before a library looks at the file."""
    if zipfile.is_zipfile(io.BytesIO(data)):
        raise refused("KS441", "the file is an archive; archives are not opened", beside.file, "unpack it")
    try:
        parse_xml(data, str(beside.file), max_bytes=MAX_BYTES)
    except RobotFileError as failure:
        code = "KS448" if failure.code == "KS110" else "KS443"
        hint = "delete the <!DOCTYPE ...> block" if failure.code == "KS110" else failure.hint
        message = "DOCTYPE/ENTITY is not allowed in a mesh" if code == "KS448" else f"not COLLADA: {failure.message}"
        raise RobotFileError(code, message, hint, failure.place) from None


def _without_broken_materials(data: bytes, sound: set[str]) -> bytes:
    """The document without references to materials that could not be read."""
    root = ElementTree.fromstring(data)
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag.endswith("}instance_material") and child.get("target", "").removeprefix("#") not in sound:
                parent.remove(child)
    return ElementTree.tostring(root)


def _geometries(nodes: Any, beside: Beside) -> Iterator[tuple[Any, Array]]:
    """Every geometry that is drawn, and where: a node may be drawn many times, and a hostile one without end."""
    import collada

    stack = [(node, np.eye(4)) for node in reversed(nodes)]
    visited = 0
    while stack:
        node, T = stack.pop()
        visited += 1
        if visited + len(stack) > MAX_NODES:
            raise refused("KS449", f"the scene of the mesh draws more than {MAX_NODES} nodes", beside.file)
        if isinstance(node, collada.scene.GeometryNode):
            yield node, T
        elif isinstance(node, collada.scene.Node):
            T_here = T @ np.asarray(node.matrix, dtype=float)
            stack.extend((child, T_here) for child in reversed(node.children or []))


def _parts(node: Any, beside: Beside) -> Iterator[Part]:
    """The triangles of one geometry, by material."""
    import collada

    colors = {bound.symbol: _color(bound.target) for bound in node.materials}
    for primitive in node.geometry.primitives:
        color = colors.get(primitive.material)
        if isinstance(primitive, collada.polylist.Polylist):
            sides = np.asarray(primitive.vcounts)
            if len(sides) and (sides.min() < 0 or sides.sum() > len(primitive.index)):
                raise refused("KS445", "a polygon of the mesh has more corners than are given", beside.file)
            triangles = primitive.triangleset()
        elif isinstance(primitive, collada.triangleset.TriangleSet):
            triangles = primitive
        else:
            continue  # lines
        if triangles.vertex is not None:
            yield Part(np.asarray(triangles.vertex, dtype=float), np.asarray(triangles.vertex_index), color)


def _color(material: Any) -> Array | None:
    """The diffuse colour, opaque: files disagree about what their transparency means. None where it is a picture."""
    diffuse = getattr(getattr(material, "effect", None), "diffuse", None)
    if not isinstance(diffuse, tuple | list | np.ndarray) or len(diffuse) < 3:
        return None
    red, green, blue, *_ = diffuse
    return 255 * np.clip(np.array([red, green, blue], dtype=float), 0.0, 1.0)
