"""Optional packages: which extra brings them, and what for. Floor 1.

What may be missing is imported where it is used, and its absence is `errors.missing_extra`. Least versions are said in
pyproject.toml alone; here they are read from the metadata of the installed package.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib import metadata
from typing import NamedTuple


class Extra(NamedTuple):
    """One extra of the package.

    Attributes:
        name: as in pip install 'kinestatics[name]'.
        packages: what it installs.
        purpose: what for.
    """

    name: str
    packages: tuple[str, ...]
    purpose: str

    @property
    def command(self) -> str:
        """What installs it."""
        return f"pip install 'kinestatics[{self.name}]'"


BASE = ("numpy", "typer")
"""Packages that are always needed."""
EXTRAS = (
    Extra("view", ("viser", "trimesh", "pycollada"), "the explorer, scenes in three dimensions, meshes"),
    Extra("report", ("latex2mathml", "ziamath", "weasyprint", "plotly"), "reports: mathematics, PDF, figures that turn"),
    Extra("symbolic", ("sympy", "python-flint"), "closed forms, singularities by name, code"),
    Extra("plot", ("matplotlib",), "pictures"),
    Extra("mjcf", ("mujoco",), "MuJoCo models (.xml)"),
    Extra("xacro", ("xacro",), "xacro files"),
    Extra("qp", ("daqp",), "inverse velocity within limits"),
    Extra("grasp", ("scipy",), "force closure of grasps"),
)
_IMPORTED_AS = {"python-flint": "flint", "pycollada": "collada"}


def imported_as(package: str) -> str:
    """The name by which a package is imported.

    Example:
        >>> imported_as("python-flint"), imported_as("mujoco")
        ('flint', 'mujoco')
    """
    return _IMPORTED_AS.get(package, package.replace("-", "_"))


def version_of(package: str) -> str | None:
    """The installed version of a package, or None."""
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def bounds_of(package: str) -> str:
    """The versions that kinestatics asks for, such as ">=1.1,<1.2"; empty where it says nothing, or is not installed."""
    for name, bounds in _requirements():
        if _normal(name) == _normal(package):
            return bounds
    return ""


def _requirements() -> Iterator[tuple[str, str]]:
    """Name and bounds of every requirement, those of extras included."""
    try:
        texts = metadata.requires("kinestatics") or []
    except metadata.PackageNotFoundError:
        return
    for text in texts:
        if found := re.match(r"\s*([A-Za-z0-9][A-Za-z0-9._-]*)\s*(?:\[[^\]]*\])?\s*\(?([^;()]*)", text):
            yield found[1], found[2].replace(" ", "")


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def within(version: str, bounds: str) -> bool:
    """Whether a version lies within bounds of the kinds >=, >, <=, < and ==; other kinds are taken as kept.

    Example:
        >>> within("1.10.2", ">=1.9,<2"), within("1.10.2", ">=2"), within("2.0rc1", "")
        (True, False, True)
    """
    given = _numbers(version)
    for bound in filter(None, bounds.split(",")):
        relation = bound[: len(bound) - len(bound.lstrip("<>=!~"))]
        limit = _numbers(bound[len(relation) :])
        size = max(len(given), len(limit))
        a, b = (numbers + [0] * (size - len(numbers)) for numbers in (given, limit))
        if not {">=": a >= b, ">": a > b, "<=": a <= b, "<": a < b, "==": a == b}.get(relation, True):
            return False
    return True


def _numbers(version: str) -> list[int]:
    """The leading whole numbers of a version: 2.0rc1 is 2, 0."""
    leading = re.match(r"\s*v?(\d+(?:\.\d+)*)", version)
    return [int(part) for part in leading[1].split(".")] if leading else []
