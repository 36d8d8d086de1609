"""MJCF: the model files of MuJoCo. Floor 4.

MuJoCo itself compiles the model, in a bounded child, so that defaults, classes, frames and orientations mean here what they
mean there; this module turns the compiled bodies into links and joints. q is MuJoCo's qpos. Meshes are opened only where a
mass is inferred from one. Gravity, springs and gravity compensation are not taken from the file; a finding says so.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import Finding, Place, RobotFileError
from .bounded import Limits, package_folder, run_bounded
from .checks import NOT_YET, below, checked
from .description import JointDescription, RobotDescription
from .mjcf_extras import settle_masses, with_couplings, with_efforts, with_home
from .mjcf_source import STANDARD_GRAVITY, Source, read_source
from .mjcf_tree import Names, default_tip, joints_of, links_of, sites_of

LIMITS = Limits(processor=20, wall=30.0, memory=4 << 30)
_NUMBERS = ("position", "quaternion", "mass", "center", "axes", "inertia", "anchor", "axis", "reference")

REFUSALS = (  # what MuJoCo says, the code, a remedy
    (r"Schema violation|unrecognized", "KS124", "MuJoCo does not know it; the version of MuJoCo may be older than the file"),
    (r"required attribute missing", "KS125", ""),
    (r"repeated name .* in body", "KS130", "names are unique"),
    (r"repeated name .* in joint", "KS131", "names are unique"),
    (r"World body cannot have joints", "KS138", "put the joint into a <body>"),
    (r"axis too small", "KS142", 'give a direction, for example axis="0 0 1"'),
    (r"does not have enough data|has too much data", "KS144", ""),
    (r"bad format|number is too large", "KS145", ""),
    (r"zero quaternion|quaternion.*too small", "KS147", 'for no rotation: quat="1 0 0 0"'),
    (r"range\[0\] should be smaller", "KS152", "exchange them"),
    (r"size \d must be positive|negative size", "KS164", "a size is above 0"),
    (r"density are negative", "KS160", "a mass is at least 0"),
    (r"Could not allocate|unknown exception|bad_alloc", "KS108", "make the model smaller"),
)


def read_mjcf(path: Path, *, package_roots: Sequence[Path] = (), base: str | None = None) -> RobotDescription:
    """The robot in a MuJoCo model.

    Bodies are links, hinges and slides are joints; a body with several joints has a massless link between each two. Named
    sites are links too, fixed to their bodies. The root link is MuJoCo's "world".

    Args:
        path: the file.
        package_roots: folders in which included files and meshes may lie, besides the model's own.
        base: link to start from, where joints of several freedoms lie above it.

    Raises:
        RobotFileError: KS100-KS192, with file, line and column.
        MissingExtraError: KS400, without the package mujoco.
    """
    folder = package_folder("mujoco", "mjcf", "reading a MuJoCo model")
    source = read_source(path, package_roots)
    return _describe(compiled(source, folder), source, base)


def compiled(source: Source, folder: str, shapes: bool = False) -> dict[str, Any]:
    """What MuJoCo says about a model, from a bounded child (`mjcf_child`).

    Args:
        source: the model; folder: where the package mujoco lies.
        shapes: say what the bodies look like, and nothing sound about masses.

    Raises:
        RobotFileError: KS108 a limit, KS192 no answer, or the code that goes with MuJoCo's refusal.
    """
    request = {"folder": folder, "text": source.text, "submodels": source.submodels, "meshes": source.meshes}
    answer = run_bounded("mjcf_child", request | {"shapes": shapes}, LIMITS, Place(str(source.path)))
    if "refused" in answer:
        raise _refusal(answer["refused"], source)
    return answer


def _refusal(text: str, source: Source) -> RobotFileError:
    """MuJoCo's message as an error with a stable code and the place in the file."""
    message, _, rest = re.sub(r"^(XML )?Error: (Error: )?", "", text.strip()).partition("\n")
    line = re.search(r"line (\d+)", rest)
    place = source.place(int(line[1]) if line else 0)
    if element := re.search(r"Element (?:name )?'([^']+)'", rest):
        message += f" ({element[1]!r})"
    for pattern, code, hint in REFUSALS:
        if re.search(pattern, message):
            return RobotFileError(code, f"MuJoCo: {message}", hint, place)
    return RobotFileError("KS191", f"MuJoCo refuses the model: {message}", "", place)


def _describe(answer: dict[str, Any], source: Source, base: str | None) -> RobotDescription:
    _check_finite(answer, source)
    names = Names(answer, source)
    findings = [*source.findings, *names.findings]
    joints, index, between = joints_of(answer, names, source)
    _check_freedoms(joints, base)
    joints = with_efforts(joints, index, answer, findings)
    joints = with_couplings(joints, index, answer, source, findings)
    joints = with_home(joints, index, answer, source, findings)
    links = settle_masses(links_of(answer, names, source), answer, names, base, findings)
    site_links, site_joints = sites_of(answer, names, source)
    links, joints = below([*links, *between, *site_links], [*joints, *site_joints], base, findings)
    findings += _left_out(answer, names, source)
    tip = default_tip(answer, names)
    tip = tip if tip in {link.name for link in links} else None
    return checked(source.name, links, joints, source=str(source.path), base=base, findings=findings, tip=tip)


def _left_out(answer: dict[str, Any], names: Names, source: Source) -> list[Finding]:
    """What acts on the arm in MuJoCo and is not part of this model: a torque computed without it may surprise."""
    place, found = Place(str(source.path)), []
    if source.gravity != STANDARD_GRAVITY:
        shown = ", ".join(f"{g:g}" for g in source.gravity)
        found.append(Finding("KS176", f"the file's gravity ({shown}) is not used; pass gravity=({shown})", place))
    lifted = [names.links[body["id"]] for body in answer["bodies"] if body["compensated"]]
    if lifted:
        found.append(Finding("KS177", f"gravcomp of {', '.join(lifted[:5])} is not modelled: gravity acts in full", place))
    if answer["springs"]:
        shown = ", ".join(name or "an unnamed joint" for name in answer["springs"][:5])
        found.append(Finding("KS178", f"springs in joints are not modelled: {shown}", place))
    return found


def _check_finite(answer: dict[str, Any], source: Source) -> None:
    """Numbers that are each sound may still multiply to infinity in MuJoCo."""
    for what in ("bodies", "joints", "sites"):
        for entry in answer[what]:
            values = [entry[word] for word in _NUMBERS if word in entry]
            if not np.all(np.isfinite(np.concatenate([np.ravel(value) for value in values]))):
                message = f"{what[:-1]} {entry['name']!r}: a number is not finite after MuJoCo has compiled it"
                raise RobotFileError("KS146", message, "look for a wrong unit", source.place(entry["line"]))


def _check_freedoms(joints: Sequence[JointDescription], base: str | None) -> None:
    """Without a base named, the whole model is read, and every joint must have one freedom."""
    for joint in joints:
        if joint.kind in NOT_YET and base is None:
            message = f"joint {joint.name!r}: a {joint.kind} joint has several freedoms, which is not supported yet"
            raise RobotFileError("KS140", message, f"pass base={joint.child!r}, or another link behind it", joint.place)
