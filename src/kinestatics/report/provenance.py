"""Where the numbers come from: file, hash, versions, seed, command. No date: the same input makes the same page."""

from __future__ import annotations

import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import PurePath

import numpy as np

from .blocks import Html, definitions, section, tag
from .page import Report


def provenance_section(report: Report) -> Html:
    """The last section."""
    model = report.model
    file = "" if model.file is None else PurePath(model.file.path).name
    pairs = [
        ("Robot", f"{model.name}{f', from {file}' if file else ''}"),
        ("Source", model.source if not file else None),
        ("SHA-256", tag("code", model.digest) if model.digest else "none: the robot was made in Python"),
        ("Held joints", ", ".join(f"{name} at {value:g}" for name, value in model.frozen.items())),
        ("Command", tag("code", report.command) if report.command else "made from Python: analysis.to_html()"),
        ("Seed", None if report.seed is None else str(report.seed)),
        ("kinestatics", _version("kinestatics")),
        ("Python", f"{platform.python_version()} ({sys.implementation.name})"),
        ("NumPy", np.__version__),
        *((name, _version(package)) for name, package in (("SymPy", "sympy"), ("python-flint", "python-flint"))),
        ("Mathematical font", "STIX Two Math (a subset), SIL Open Font License 1.1"),
    ]
    lead = "The same robot, question and versions give this page again, byte for byte."
    return section(
        "Where this comes from", definitions(((k, v) for k, v in pairs if v), kind="provenance"), id="provenance", lead=lead
    )


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "not installed"
