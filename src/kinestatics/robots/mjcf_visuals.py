"""The shapes of a MuJoCo model: geoms of the groups that MuJoCo shows. Floor 4.

MuJoCo resolves classes, frames and orientations, in the bounded child of `mjcf`; it is given no mesh. A mesh is drawn from
its file, so one that is written in the model itself is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import Finding, RobotFileError
from ..namespaces import Array
from ..spatial import inverse_pose
from .bounded import package_folder
from .mjcf import compiled
from .mjcf_source import Source, read_source
from .mjcf_tree import Names, pose
from .shapes import Kind, Visual, checked_shape

SHOWN_GROUPS = (0, 1, 2)
_LEFT_OUT = ("plane", "hfield")  # the ground
_NO_SCALE = (1.0, 1.0, 1.0)


def mjcf_visuals(path: Path, roots: Sequence[Path]) -> tuple[list[Visual], list[Finding]]:
    """The shapes of all bodies, and what cannot be shown.

    Raises:
        RobotFileError: KS100-KS192, as `read_mjcf`.
        MissingExtraError: KS400, without the package mujoco.
    """
    folder = package_folder("mujoco", "mjcf", "reading a MuJoCo model")
    source = read_source(path, roots, colors=True)
    answer = compiled(source, folder, shapes=True)
    names = Names(answer, source)
    shapes: list[Visual] = []
    findings = [finding for finding in source.findings if finding.message.startswith("mesh ") or finding.code == "KS111"]
    for entry in answer["shapes"]:
        if entry["group"] not in SHOWN_GROUPS or entry["kind"] in _LEFT_OUT:
            continue
        try:
            shape = _visual(entry, names.links[entry["body"]], source)
        except RobotFileError as failure:
            findings.append(Finding(failure.code, failure.message, failure.place))
            continue
        if shape is not None:
            shapes.append(shape)
    return shapes, findings


def _visual(entry: dict[str, Any], link: str, source: Source) -> Visual | None:
    """One geom; None where its mesh is missing, which is a finding of the source."""
    place = source.place(entry["line"])
    T = pose(entry)
    if not np.all(np.isfinite(T)):
        raise RobotFileError("KS146", f"link {link!r}: the place of a geom is not finite", "", place)
    red, green, blue, opacity = np.clip(entry["color"], 0.0, 1.0).tolist()
    color = (red, green, blue, opacity)
    if entry["kind"] != "mesh":
        kind, size = _primitive(entry, link, source)
        return checked_shape(Visual(link, kind, T, size, None, _NO_SCALE, color, entry["name"]), place)
    mesh = entry["mesh"]
    if mesh is None or mesh["file"] not in source.meshes:
        message = f"link {link!r}: a mesh that is written in the model itself is not drawn"
        raise RobotFileError("KS124", message, "", place)
    file = source.meshes[mesh["file"]]
    if file is None:
        return None
    T, scale = _placement(T, mesh, link, source, entry["line"])
    return checked_shape(Visual(link, "mesh", T, (), Path(file), scale, color, entry["name"]), place)


def _primitive(entry: dict[str, Any], link: str, source: Source) -> tuple[Kind, tuple[float, ...]]:
    """Kind and size; MuJoCo keeps half-lengths."""
    x, y, z = entry["size"]
    if entry["kind"] == "box":
        return "box", (2 * x, 2 * y, 2 * z)
    if entry["kind"] == "cylinder":
        return "cylinder", (x, 2 * y)
    if entry["kind"] == "capsule":
        return "capsule", (x, 2 * y)
    if entry["kind"] == "ellipsoid":
        return "ellipsoid", (x, y, z)
    if entry["kind"] == "sphere":
        return "sphere", (x,)
    message = f"link {link!r}: a geom of type {entry['kind']!r} cannot be drawn"
    raise RobotFileError("KS124", message, "", source.place(entry["line"]))


def _placement(
    T: Array, mesh: dict[str, Any], link: str, source: Source, line: int
) -> tuple[Array, tuple[float, float, float]]:
    """Pose and scale of a mesh file: MuJoCo moves its points by the inverse of refpos and refquat, then stretches them."""
    scale = np.array(mesh["scale"])
    T_reference_file = inverse_pose(pose(mesh))
    turned = not np.allclose(T_reference_file[:3, :3], np.eye(3), atol=1e-12)
    if turned and np.ptp(scale) > 0:
        message = f"link {link!r}: a mesh that is turned by refquat and then stretched unevenly is not drawn"
        raise RobotFileError("KS124", message, "", source.place(line))
    T_reference_file[:3, 3] *= scale
    x, y, z = scale.tolist()
    return T @ T_reference_file, (x, y, z)
