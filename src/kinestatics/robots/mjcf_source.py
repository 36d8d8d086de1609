"""What MuJoCo is given of a MuJoCo model: read strictly, includes put in, files kept inside their folders. Floor 4.

MuJoCo opens what a file names, expands without bound and lets NaN pass. So the file is read here first, and what is handed
on is one text without paths and without what only a viewer or a simulator needs, each element on a line of its own:
MuJoCo's "line 12" is then a place in a file.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import prod
from pathlib import Path, PurePosixPath
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

from ..errors import Finding, Place, RobotFileError
from .paths import resolve
from .xml import MAX_ELEMENTS, Element, numbers_in, parse_xml, read_file, read_number, read_vector, required

STANDARD_GRAVITY = (0.0, 0.0, -9.81)  # MuJoCo's
MAX_DEPTH = 256
MAX_GENERATED = 20_000
MAX_FILES = 100
MAX_MEMORY = 2 << 30
SECTIONS_LEFT_OUT = {
    "option",
    "size",
    "visual",
    "statistic",
    "contact",
    "sensor",
    "custom",
    "deformable",
    "extension",
    "tendon",
}
LEFT_OUT = {"camera", "light", "composite", "flexcomp", "texture", "material", "skin", "hfield"}
ATTRIBUTES_LEFT_OUT = {"user", "material"}
OF_COMPILER_LEFT_OUT = {"meshdir", "texturedir", "assetdir", "strippath", "discardvisual", "fusestatic", "usethread"}
NUMERIC = (
    "pos", "quat", "axisangle", "euler", "xyaxes", "zaxis", "axis", "range", "ref", "size", "fromto", "mass", "density",
    "diaginertia", "fullinertia", "offset", "count", "scale", "refpos", "refquat", "vertex", "polycoef", "gear", "ctrlrange",
    "forcerange", "actuatorfrcrange", "gainprm", "biasprm", "qpos", "armature", "boundmass", "boundinertia", "settotalmass",
    "inertiagrouprange",
)  # fmt: skip
_BYTES = {"": 1, "k": 1 << 10, "m": 1 << 20, "g": 1 << 30, "t": 1 << 40, "p": 1 << 50, "e": 1 << 60}


@dataclass
class Source:
    """A model ready for MuJoCo.

    Attributes:
        path: the file; roots: folders in which its files may lie besides its own.
        text: the model; submodels: those it attaches, by the name that `text` uses.
        meshes: path of each mesh file by the name that `text` uses, None where there is none.
        places: where each line of `text` and of the submodels came from; line 1 is the first.
        findings: what was met on the way.
        partial: whether moving parts were left out, so that positions of the whole model no longer fit.
        name: the model's own name, or that of the file.
        gravity: what the file says, MuJoCo's default where it says nothing [m/s²].
        files: how many files were read; attached: how many models were attached.
        colors: whether materials are handed on, as no more than a colour.
    """

    path: Path
    roots: Sequence[Path]
    text: str = ""
    submodels: dict[str, str] = field(default_factory=dict)
    meshes: dict[str, str | None] = field(default_factory=dict)
    places: list[Place] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    partial: bool = False
    name: str = ""
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    files: int = 0
    attached: int = 0
    colors: bool = False

    def place(self, line: int) -> Place:
        """Where the line that MuJoCo names came from."""
        return self.places[line - 1] if 0 < line <= len(self.places) else Place(str(self.path))


def read_source(path: Path, roots: Sequence[Path], colors: bool = False) -> Source:
    """The model in a file, checked and stripped; with the colours of its materials where they are asked for.

    Raises:
        RobotFileError: KS100-KS112, KS120, KS125, KS145, KS146, KS160, KS190, with file, line and column.
    """
    source = Source(path, roots, colors=colors)
    root = _read(path, source)
    if root.tag != "mujoco":
        raise RobotFileError("KS120", f"root element is <{root.tag[:40]}>; expected <robot> or <mujoco>", "", root.place)
    source.name = root.attributes.get("model", "") or path.stem
    source.text = _prepare(root, path, source)
    for option in root.all("option"):  # of this model, what it includes among it; attached models bring none
        if "gravity" in option.attributes:
            x, y, z = read_vector(option.attributes["gravity"], 3, "option: gravity", option.place).tolist()
            source.gravity = (x, y, z)
    return source


def _read(path: Path, source: Source) -> Element:
    source.files += 1
    if source.files > MAX_FILES:
        raise RobotFileError("KS108", f"the model takes more than {MAX_FILES} files", "", Place(str(path)))
    return parse_xml(read_file(path), str(path), max_depth=MAX_DEPTH)


def _prepare(root: Element, path: Path, source: Source) -> str:
    """The text of one model, main or attached."""
    _include(root, path, source)
    _check_growth(root)
    for element in root.walk():
        _check(element)
    return _write(root, _asset_folders(root), path.parent, source)


def _find(name: str, place: Place, folder: Path, roots: Sequence[Path]) -> tuple[Path | None, list[Path]]:
    """A file as MuJoCo looks for it: from the model's folder, then from the folder of the file that names it."""
    try:
        found, tried = resolve(name, folder, roots, place)
    except RobotFileError:
        if Path(place.file).parent.resolve() == folder.resolve():
            raise
        found, tried = None, []
    beside = Path(place.file).parent.resolve()
    if found is None and beside != folder.resolve() and "://" not in name:
        found, more = resolve(str(beside / name), folder, roots, place)
        tried = [*tried, *more]
    return found, tried


def _include(root: Element, path: Path, source: Source) -> None:
    """Puts the children of an included file in the place of each <include>; MuJoCo includes a file once at most."""
    seen = {path.resolve()}
    count = 0
    stack = [(root, 1)]
    while stack:
        parent, depth = stack.pop()
        if depth > MAX_DEPTH:
            raise RobotFileError("KS103", f"elements nested deeper than {MAX_DEPTH}", "", parent.place)
        waiting, children = parent.children[::-1], []
        while waiting:
            child = waiting.pop()
            if child.tag == "include":
                waiting.extend(_included(child, path, source, seen)[::-1])
                continue
            children.append(child)
            count += 1
        if count > MAX_ELEMENTS:
            raise RobotFileError("KS102", f"more than {MAX_ELEMENTS} elements", "", parent.place)
        parent.children[:] = children
        stack.extend((child, depth + 1) for child in children)


def _included(element: Element, path: Path, source: Source, seen: set[Path]) -> list[Element]:
    name = required(element, "file", "include")
    found, tried = _find(name, element.place, path.parent, source.roots)
    if found is None:
        searched = ", ".join(str(p) for p in tried[:4])
        raise RobotFileError("KS190", f"included file {name!r} not found; searched: {searched}", "", element.place)
    if found in seen:
        message = f"file {name!r} is included a second time, or includes itself"
        raise RobotFileError("KS190", message, "MuJoCo includes a file once; use <default> or <replicate>", element.place)
    seen.add(found)
    try:
        return _read(found, source).children
    except RobotFileError as failure:
        if failure.code not in ("KS100", "KS105"):
            raise
        message = f"included file {name!r} is not MJCF: {failure.message}"
        raise RobotFileError("KS190", message, failure.hint, element.place) from None


def _check(element: Element) -> None:
    """What must hold of one element, whether it is handed on or not."""
    tag, place = element.tag, element.place
    if tag == "plugin":
        raise RobotFileError("KS112", "plugins are not loaded: they are code", "delete the <plugin> elements", place)
    if tag == "size" and (text := element.attributes.get("memory", "")):
        found = re.fullmatch(r"\s*(\d{1,30})\s*([kmgtpe]?)\s*", text.lower())
        _check_memory(int(found[1]) * _BYTES[found[2]] if found else 0, "size", place)
    if tag == "hfield":
        _check_memory(4 * prod(_whole(element, word) for word in ("nrow", "ncol")), tag, place)
    if tag == "texture":
        _check_memory(3 * prod(_whole(element, word) for word in ("width", "height")), tag, place)
    if tag in SECTIONS_LEFT_OUT or tag in LEFT_OUT:
        return
    numbers = numbers_in(element, NUMERIC)
    if tag == "inertial" and numbers.get("mass", [0.0])[0] < 0:
        raise RobotFileError("KS160", "mass is negative", "a mass is at least 0", place)


def _whole(element: Element, name: str) -> int:
    """A whole number that may be missing; what is not one is left to MuJoCo."""
    text = element.attributes.get(name, "0").strip()
    return int(text) if re.fullmatch(r"\d{1,18}", text) else 0


def _check_memory(size: int, tag: str, place: Place) -> None:
    if size > MAX_MEMORY:
        message = f"<{tag}> would need {size / (1 << 30):.1f} GB; the limit is {MAX_MEMORY >> 30} GB"
        raise RobotFileError("KS107", message, "make it smaller", place)


def _check_growth(root: Element) -> None:
    """Elements that <replicate>, <flexcomp> and <composite> will make, before anything makes them."""
    total = 0
    stack = [(root, 1)]
    while stack:
        element, times = stack.pop()
        if element.tag in ("replicate", "flexcomp", "composite") and (text := element.attributes.get("count")):
            counts = [read_number(word, f"<{element.tag} count>", element.place) for word in text.split()]
            times *= int(max(1.0, prod(max(1.0, count) for count in counts)))
        total += times if times > 1 else 0
        if total > MAX_GENERATED:
            message = f"more than {MAX_GENERATED} elements after <{element.tag}>"
            raise RobotFileError("KS108", message, "replicate or generate fewer parts", element.place)
        stack.extend((child, times) for child in reversed(element.children))


class _AssetFolders(NamedTuple):
    """Where the files of assets lie, and whether folders in their names are ignored."""

    meshes: str = ""
    textures: str = ""
    strip: bool = False

    def path(self, tag: str, file: str) -> str:
        """A file as it is to be looked for."""
        name = PurePosixPath(file.replace("\\", "/")).name if self.strip else file
        return name if "://" in name else str(Path(self.textures if tag == "texture" else self.meshes) / name)


def _asset_folders(root: Element) -> _AssetFolders:
    """From the compiler settings; later ones replace earlier ones."""
    meshes, textures, strip = "", "", False
    for compiler in root.all("compiler"):
        both = compiler.attributes.get("assetdir")
        meshes = compiler.attributes.get("meshdir", meshes if both is None else both)
        textures = compiler.attributes.get("texturedir", textures if both is None else both)
        strip = compiler.attributes.get("strippath", str(strip).lower()) == "true"
    return _AssetFolders(meshes, textures, strip)


def _write(root: Element, folders: _AssetFolders, folder: Path, source: Source) -> str:
    """The text, one tag a line, continuing the count of lines of the texts before it."""
    lines = [""] * len(source.places)
    stack: list[Element | str] = [root]
    submodels: dict[str, Path] = {}
    while stack:
        element = stack.pop()
        if isinstance(element, str):
            lines.append(element)
            source.places.append(source.places[-1])
            continue
        attributes = _attributes(element, folders, folder, source, submodels)
        text = "".join(f" {name}={quoteattr(value)}" for name, value in attributes.items())
        lines.append(f"<{element.tag}{text}>")
        source.places.append(element.place)
        stack.append(f"</{element.tag}>")
        stack.extend(child for child in reversed(element.children) if _kept(element, child, folders, folder, source))
    for token, path in submodels.items():
        source.submodels[token] = _prepare(_read(path, source), path, source)
    return "\n".join(lines)


def _kept(parent: Element, child: Element, folders: _AssetFolders, folder: Path, source: Source) -> bool:
    """Whether an element is handed to MuJoCo. What it does not know is, so that it can refuse it."""
    if parent.tag == "mujoco" and child.tag in SECTIONS_LEFT_OUT:
        return False
    if child.tag in ("flexcomp", "composite"):
        source.partial = True
        message = f"<{child.tag}> is left out, with its mass: deformable parts are not modelled"
        source.findings.append(Finding("KS175", message, child.place))
    if child.tag in ("hfield", "texture", "skin") and (file := child.attributes.get("file")):
        _look_for(child.tag, folders.path(child.tag, file), child.place, folder, source)
    if child.tag == "key":
        return child.attributes.get("name") == "home"
    return child.tag not in LEFT_OUT or parent.tag == "default" or (source.colors and child.tag == "material")


def _look_for(what: str, name: str, place: Place, folder: Path, source: Source) -> Path | None:
    """The file of that name where it is there and inside the folders; else a finding and None. It is not opened."""
    try:
        found, tried = _find(name, place, folder, source.roots)
    except (RobotFileError, OSError, ValueError) as failure:
        message = failure.message if isinstance(failure, RobotFileError) else f"{what} {name!r}: {failure}"
        source.findings.append(Finding("KS111", message, place))
        return None
    if found is None:
        searched = ", ".join(str(path) for path in tried[:4])
        source.findings.append(Finding("KS180", f"{what} {name!r} not found; searched: {searched}", place))
    return found


def _attributes(
    element: Element,
    folders: _AssetFolders,
    folder: Path,
    source: Source,
    submodels: dict[str, Path],
) -> dict[str, str]:
    """The attributes handed on; names of files are replaced by names that mean nothing outside."""
    left_out = ATTRIBUTES_LEFT_OUT - {"material"} if source.colors and element.tag == "geom" else ATTRIBUTES_LEFT_OUT
    attributes = {name: value for name, value in element.attributes.items() if name not in left_out}
    if element.tag == "material":
        return {name: value for name, value in attributes.items() if name in ("name", "class", "rgba")}
    if element.tag == "compiler":
        return {name: value for name, value in attributes.items() if name not in OF_COMPILER_LEFT_OUT}
    if element.tag == "key":
        return {name: value for name, value in attributes.items() if name in ("name", "qpos")}
    if element.tag == "mesh" and (file := attributes.get("file")):
        bare = PurePosixPath(file.replace("\\", "/"))
        attributes.setdefault("name", bare.stem)
        found = _look_for("mesh", folders.path("mesh", file), element.place, folder, source)
        attributes["file"] = f"mesh_{len(source.meshes)}{bare.suffix}"
        source.meshes[attributes["file"]] = None if found is None else str(found)
    if element.tag == "model" and (file := attributes.get("file")):
        found, _ = _find(file, element.place, folder, source.roots)
        if found is None:
            raise RobotFileError("KS190", f"attached model {file!r} not found", "", element.place)
        source.attached += 1
        attributes["file"] = f"submodel_{source.attached}.xml"
        submodels[attributes["file"]] = found
    return attributes
