"""Boxes, cylinders, spheres, capsules and ellipsoids as triangles. Floor 10.

Every shape is closed, its triangles are anticlockwise seen from outside, and its corners lie on the true surface: a round
one is a little smaller than it should be, by less the more sides it has.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..namespaces import Array
from ..robots.shapes import Visual
from .meshes import TriangleMesh, load_mesh

SIDES = 24
"""Of a circle, where nobody says otherwise: from a step away it looks round."""


def triangles_of(visual: Visual) -> TriangleMesh:
    """The triangles of any shape of a robot, in the axes of the shape [m].

    Raises:
        KinestaticsError: KS440-KS449, when the file of a mesh cannot be read.
        MissingExtraError: KS400, a mesh that needs trimesh or pycollada.
    """
    if visual.kind == "mesh":
        assert visual.file is not None
        return load_mesh(visual.file, scale=visual.scale)
    makers: dict[str, Callable[..., TriangleMesh]] = {
        "box": box,
        "cylinder": cylinder,
        "sphere": sphere,
        "capsule": capsule,
        "ellipsoid": ellipsoid,
    }
    return makers[visual.kind](*visual.size)


def box(x: float, y: float, z: float) -> TriangleMesh:
    """A box of these edges [m] about the origin: 12 triangles."""
    corners = np.array([[i, j, k] for i in (-0.5, 0.5) for j in (-0.5, 0.5) for k in (-0.5, 0.5)])
    squares = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return _mesh(corners * (x, y, z), np.concatenate([squares[:, [0, 1, 2]], squares[:, [0, 2, 3]]]))


def cylinder(radius: float, length: float, sides: int = SIDES) -> TriangleMesh:
    """A cylinder about the z axis, its middle at the origin [m]; flat at both ends."""
    half = length / 2
    return _turned(np.array([[0.0, -half], [radius, -half], [radius, half], [0.0, half]]), sides)


def sphere(radius: float, sides: int = SIDES) -> TriangleMesh:
    """A sphere about the origin [m]; its poles lie on the z axis."""
    return capsule(radius, 0.0, sides)


def capsule(radius: float, length: float, sides: int = SIDES) -> TriangleMesh:
    """A cylinder about the z axis with half a sphere at each end; `length` is that of the cylinder alone [m]."""
    rings = max(2, sides // 4)
    angles = np.linspace(0.0, np.pi / 2, rings + 1)
    upper = np.column_stack([radius * np.cos(angles), radius * np.sin(angles) + length / 2])
    upper[-1, 0] = 0.0
    lower = (upper * (1, -1))[::-1]
    return _turned(np.concatenate([lower, upper[1:] if length == 0.0 else upper]), sides)


def ellipsoid(x: float, y: float, z: float, sides: int = SIDES) -> TriangleMesh:
    """An ellipsoid of these half-axes about the origin [m]."""
    ball = sphere(1.0, sides)
    return _mesh(ball.vertices.astype(float) * (x, y, z), ball.faces)


def _turned(outline: Array, sides: int) -> TriangleMesh:
    """The surface that an outline (k, 2) of radius and height makes about z; it begins and ends on the axis, going up."""
    angles = 2 * np.pi * np.arange(sides) / sides
    circle = np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [np.column_stack([radius * circle, np.full(sides, height)]) for radius, height in outline[1:-1]]
    ends = [[0.0, 0.0, outline[0, 1]], [0.0, 0.0, outline[-1, 1]]]
    here = np.arange(sides)
    after = (here + 1) % sides
    bottom, top = len(rings) * sides, len(rings) * sides + 1
    faces = [np.column_stack([np.full(sides, bottom), after, here])]
    for ring in range(len(rings) - 1):
        low, high = ring * sides, (ring + 1) * sides
        faces.append(np.column_stack([low + here, low + after, high + after]))
        faces.append(np.column_stack([low + here, high + after, high + here]))
    last = (len(rings) - 1) * sides
    faces.append(np.column_stack([np.full(sides, top), last + here, last + after]))
    return _mesh(np.concatenate([*rings, ends]), np.concatenate(faces))


def _mesh(vertices: Array, faces: Array) -> TriangleMesh:
    return TriangleMesh(np.asarray(vertices, dtype=np.float32), np.asarray(faces, dtype=np.int32))
