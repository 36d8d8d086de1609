"""`visuals`: what the links of a robot look like, read from its file again when a viewer asks. Floor 4.

Kinematics needs none of it, and nothing here stops a robot from being shown: a shape that is missing or wrong is a finding.
Mesh files are looked for and not opened.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from ..errors import Finding, KinestaticsError, Place, RobotFileError
from ..model import RobotFile, RobotModel
from .loading import file_format
from .paths import Search
from .shapes import SIZES, Kind, Visual, Visuals, checked_shape, gathered
from .urdf import read_origin
from .xml import Element, parse_xml, read_file, read_number, read_vector, required

__all__ = ["MAX_SHAPES", "Visual", "Visuals", "visuals"]

MAX_SHAPES = 5000
Color = tuple[float, float, float, float]


def visuals(model: RobotModel, package_roots: Sequence[str | PathLike[str]] = ()) -> Visuals:
    """The shapes of a robot's links, from the file it was loaded from; none for a robot of rows, screws or the catalogue.

    Of a URDF or xacro file these are the <visual> elements, of an MJCF model the geoms of groups 0 to 2, which MuJoCo shows.
    A mesh is a path to a file that is there; no mesh is opened.

    Args:
        model: as `load` returns it; a file is expanded by xacro only if `load` was allowed to.
        package_roots: folders in which package:// paths may be looked up, besides those that `load` was given.

    Returns:
        Visuals: `shapes`, each on a link of the model, and `findings`: one for all meshes that are not found (KS180), one
        for all that lie outside the folders (KS111), one for each shape that cannot be read.

    Example:
        >>> import kinestatics as ks
        >>> from kinestatics.robots.visuals import visuals
        >>> visuals(ks.load("ur5e")).shapes
        ()
    """
    if model.file is None:
        return Visuals()
    further = (os.path.abspath(root) for root in package_roots)
    file = model.file._replace(package_roots=tuple(dict.fromkeys((*further, *model.file.package_roots))))
    try:
        found, findings = _read(file)
    except RobotFileError as failure:  # the file is gone or was changed since
        return Visuals((), (_finding(failure),))
    known = set(model.link_names)
    shapes = [shape for shape in found if shape.link in known]
    if len(shapes) > MAX_SHAPES:
        message = f"the robot has {len(shapes)} shapes; the first {MAX_SHAPES} are shown"
        findings.append(Finding("KS108", message, Place(file.path)))
    return Visuals(tuple(shapes[:MAX_SHAPES]), gathered(findings))


def _read(file: RobotFile) -> tuple[list[Visual], list[Finding]]:
    """All shapes of a file, on whatever link."""
    path, roots = Path(file.path), [Path(root) for root in file.package_roots]
    form = file_format(path)
    if form == "mjcf":
        from .mjcf_visuals import mjcf_visuals

        return mjcf_visuals(path, roots)
    if form == "xacro":
        from .xacro import expand_xacro

        data = expand_xacro(path, allow_xacro=file.allow_xacro, package_roots=roots)
    else:
        data = read_file(path)
    root = parse_xml(data, file.path)
    return _urdf_visuals(root, Search(path.parent, roots))


def _finding(failure: KinestaticsError) -> Finding:
    return Finding(failure.code, failure.message, failure.place)


def _urdf_visuals(root: Element, search: Search) -> tuple[list[Visual], list[Finding]]:
    findings: list[Finding] = []
    shapes: list[Visual] = []
    colors = _Colors(root, findings)
    for link in root.all("link"):
        for element in link.all("visual"):
            try:
                shapes.append(_visual(element, link.attributes.get("name", ""), colors, search))
            except RobotFileError as failure:
                findings.append(_finding(failure))
    return shapes, findings


def _visual(element: Element, link: str, colors: _Colors, search: Search) -> Visual:
    what = f"link {link!r}: visual"
    shape = _geometry(element)
    kind = _kind(shape)
    file, scale = (_mesh(shape, what, search)) if kind == "mesh" else (None, (1.0, 1.0, 1.0))
    visual = Visual(
        link,
        kind,
        read_origin(element, what),
        _size(shape, kind, what),
        file,
        scale,
        colors.of(element.first("material")),
        element.attributes.get("name", ""),
    )
    return checked_shape(visual, shape.place)


def _geometry(element: Element) -> Element:
    """The one element inside <geometry>."""
    geometry = element.first("geometry")
    if geometry is None or not geometry.children:
        raise RobotFileError("KS125", "<visual> has no <geometry> with a shape in it", "", element.place)
    return geometry.children[0]


def _kind(shape: Element) -> Kind:
    for kind in ("mesh", "box", "cylinder", "sphere", "capsule"):
        if shape.tag == kind:
            return kind
    hint = "URDF knows mesh, box, cylinder, sphere and capsule"
    raise RobotFileError("KS124", f"<{shape.tag[:40]}> is no shape that can be drawn", hint, shape.place)


def _size(shape: Element, kind: Kind, what: str) -> tuple[float, ...]:
    if kind == "mesh":
        return ()
    if kind == "box":
        words = required(shape, "size", what)
        return tuple(read_vector(words, SIZES[kind], f"{what}: size", shape.place).tolist())
    names = ("radius",) if kind == "sphere" else ("radius", "length")
    return tuple(read_number(required(shape, name, what), f"{what}: {name}", shape.place) for name in names)


def _mesh(shape: Element, what: str, search: Search) -> tuple[Path, tuple[float, float, float]]:
    """The file of a mesh, which is there, and its scale.

    Raises:
        RobotFileError: KS111 it lies outside the folders, KS180 it is not found.
    """
    name = required(shape, "filename", what)
    x, y, z = read_vector(shape.attributes.get("scale", "1 1 1"), 3, f"{what}: scale", shape.place).tolist()
    found, tried = search.find(name, shape.place)
    if found is None:
        searched = ", ".join(str(path) for path in tried[:4]) or "no folder of that name (see package_roots)"
        raise RobotFileError("KS180", f"mesh {name!r} not found; searched: {searched}", "", shape.place)
    return found, (x, y, z)


class _Colors:
    """Materials by name, from the robot and from any visual, as ROS shares them: the first that has a colour counts."""

    def __init__(self, root: Element, findings: list[Finding]) -> None:
        self._findings = findings
        self._by_name: dict[str, Color] = {}
        for material in (*root.all("material"), *_materials_of_links(root)):
            name = material.attributes.get("name", "")
            if name and name not in self._by_name and (color := self._own(material)) is not None:
                self._by_name[name] = color

    def of(self, material: Element | None) -> Color | None:
        """The colour that a visual's <material> means."""
        if material is None:
            return None
        named = self._by_name.get(material.attributes.get("name", ""))
        return named if named is not None else self._own(material)

    def _own(self, material: Element) -> Color | None:
        color = material.first("color")
        if color is None:
            return None
        try:
            values = read_vector(required(color, "rgba", "material"), 4, "material: rgba", color.place)
        except RobotFileError as failure:
            if _finding(failure) not in self._findings:
                self._findings.append(_finding(failure))
            return None
        red, green, blue, opacity = np.clip(values, 0.0, 1.0).tolist()
        return red, green, blue, opacity


def _materials_of_links(root: Element) -> Iterator[Element]:
    for link in root.all("link"):
        for element in link.all("visual"):
            yield from element.all("material")
