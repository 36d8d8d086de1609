"""`inspect_robot`: everything that is wrong in a robot file, each with its place, what it means, and what to do. Floor 4."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, Literal

from ..errors import ConfigurationError, Finding, KinestaticsError, Place, nearest
from .description import RobotDescription
from .loading import file_format, load
from .mjcf import read_mjcf
from .plausibility import implausible, misspelt
from .recovery import find_faults
from .xacro import expand_xacro
from .xml import parse_xml, read_file

Severity = Literal["error", "warning", "note"]
SEVERITIES: tuple[Severity, ...] = ("error", "warning", "note")
"""An error stops the file from loading; a warning is probably a mistake; a note is good to know."""

REMEDIES = {
    "KS111": "move the file, or name its folder as a package root",
    "KS122": 'add name="..." to <robot>',
    "KS123": "rename it",
    "KS126": "give the site another name",
    "KS136": "connect them with a joint, or delete them",
    "KS140": "nothing, if the rest is not needed",
    "KS143": "write a unit vector, if another one was not meant",
    "KS150": 'add <limit lower="..." upper="..." effort="..." velocity="..."/>',
    "KS151": "add them to <limit>, in N m and rad/s (N and m/s for sliding joints)",
    "KS154": "write what the drive can do, in N m and rad/s (N and m/s for sliding joints)",
    "KS156": "give limits of the same size",
    "KS157": "write one number for each coordinate, or delete the keyframe",
    "KS161": "add an <inertial> with a <mass>, or put up with torques that leave it out",
    "KS162": "give moments about the centre of mass in kg m²; all three are above 0",
    "KS163": "the largest of the three moments is at most the sum of the others; look at units and signs",
    "KS165": "give a mass, or geometry that it can be inferred from",
    "KS180": "needed for pictures only, never for kinematics; name the folder of its package as a package root",
    "KS420": "correct the word, or move the element",
    "KS421": "correct the word",
    "KS422": "delete one of them",
    "KS423": "give lower and upper (where they are missing both are 0), or make the joint fixed",
    "KS424": "angles are in radians (180 degrees are 3.14159), lengths in metres",
    "KS425": "lengths are in metres; files in millimetres must be divided by 1000",
    "KS426": "masses are in kg, moments of inertia in kg m²",
    "KS427": "nothing, if the limits are right: home is the limit nearest to 0",
    "KS428": "add an <inertial> with a <mass> to each link, or do without gravity",
}
NOTES = ("KS122", "KS126", "KS140", "KS157", "KS173", "KS174", "KS175", "KS176", "KS177", "KS178", "KS427")
"""Findings that are no mistakes."""
_NOT_OPENED = ("KS109", "KS113", "KS181", "KS312", "KS400")
"""Errors after which nothing is known of the file: not there, not allowed, or the library that reads it is missing."""


@dataclass(frozen=True)
class Remark:
    """One thing about a robot file.

    Attributes:
        severity: "error", "warning" or "note".
        code: such as "KS142".
        message: what is wrong; remedy: what to do, empty where the message says it.
        place: file, line and column, from 1; line 0 where it is about the file as a whole.
    """

    severity: Severity
    code: str
    message: str
    remedy: str
    place: Place

    def __str__(self) -> str:
        hint = f"\n  hint: {self.remedy}" if self.remedy else ""
        return f"{self.place}: {self.severity} {self.code}: {self.message}{hint}"

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        data = asdict(self)
        data.pop("place")
        return {**data, **self.place._asdict()}


@dataclass(frozen=True)
class Inspection:
    """What was found in a robot file. Printed: a line for each remark, errors first, in the order of the file.

    Attributes:
        file: the file.
        robot: name of the robot; None where it could not be read.
        links, joints: how many links and moving joints; 0 where it could not be read.
        remarks: errors, warnings and notes.
        opened: whether the file could be examined at all.
        complete: whether every fault was looked for; after some errors nothing more can be said.

    Example:
        >>> inspect_robot("ur5e").verdict
        'nothing to remark'
    """

    file: str
    robot: str | None
    links: int
    joints: int
    remarks: tuple[Remark, ...]
    opened: bool = True
    complete: bool = True

    def count(self, severity: Severity) -> int:
        """How many remarks of that severity there are."""
        return sum(remark.severity == severity for remark in self.remarks)

    @property
    def verdict(self) -> str:
        """Counts in words, such as "2 errors, 1 warning"."""
        counts = [(self.count(severity), severity) for severity in SEVERITIES]
        return ", ".join(f"{n} {word}{'s' * (n != 1)}" for n, word in counts if n) or "nothing to remark"

    def __str__(self) -> str:
        return "\n".join([*map(str, self.remarks), f"{self.file}: {self.verdict}"])

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        plain = {name: getattr(self, name) for name in ("file", "robot", "links", "joints", "opened", "complete")}
        counts = {f"{severity}s": self.count(severity) for severity in SEVERITIES}
        return {**plain, **counts, "remarks": [remark.to_dict() for remark in self.remarks]}


def inspect_robot(
    path: str | PathLike[str],
    *,
    base: str | None = None,
    package_roots: Sequence[str | PathLike[str]] = (),
    allow_xacro: bool = False,
) -> Inspection:
    """Everything that is wrong in a robot file, as far as it can be told without meshes: they are looked for, never opened.

    A URDF file is read on after a fault, so that all of them are found; of a MuJoCo model or a xacro file the first error
    ends it. Beside what a reader must refuse there are misspelt words, units that look wrong, joints that cannot move,
    missing limits and masses, inertias that no body has, and missing meshes with the places searched.

    Args:
        path: a .urdf, .xml (MJCF or URDF) or .xacro file, or a catalogue name.
        base: link to start from, where joints of several freedoms lie above it.
        package_roots: folders in which package:// paths may be looked up, besides the model's own.
        allow_xacro: expand a xacro file. It can run code: only for files you trust.

    Returns:
        Inspection; errors are in it, never raised.

    Raises:
        ConfigurationError: KS429, the path is neither text nor a path.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.inspect_robot("nowhere.urdf"))
        nowhere.urdf: error KS109: there is no such file
        nowhere.urdf: 1 error
    """
    try:
        file = os.fspath(path)
        roots = [Path(root) for root in package_roots]
    except TypeError:
        raise ConfigurationError("KS429", f"{path!r} is not a path", 'for example ks.inspect_robot("arm.urdf")') from None
    if os.path.isdir(file):
        folder = Remark("error", "KS109", "is a folder, not a file", "name the files in it", Place(file))
        return Inspection(file, None, 0, 0, (folder,), opened=False, complete=False)
    try:
        form = file_format(Path(file)) if os.path.isfile(file) else None
        if form == "mjcf":
            return _inspection(file, (), read_mjcf(Path(file), package_roots=roots, base=base), base)
        if form is not None:
            return _inspect_urdf(file, base, roots, form == "xacro", allow_xacro)
        model = load(file, base, whole_tree=True)  # of the catalogue; or the error of what is not there
    except (KinestaticsError, OSError, ValueError) as error:
        return Inspection(file, None, 0, 0, (_of_error(error, file),), _is_opened(error), False)
    return Inspection(file, model.name, len(model.link_names), model.n, ())


def _inspect_urdf(file: str, base: str | None, roots: Sequence[Path], expand: bool, allow_xacro: bool) -> Inspection:
    """A URDF file, or what a xacro file expands to."""
    data = expand_xacro(Path(file), allow_xacro=allow_xacro, package_roots=roots) if expand else read_file(Path(file))
    faults = find_faults(data, file, package_roots=roots, base=base)
    remarks = [_of_error(error, file) for error in faults.errors]
    if not any(remark.code < "KS120" for remark in remarks):  # it is XML
        remarks += (_of_finding(finding, file) for finding in misspelt(parse_xml(data, file)))
    remarks += (_of_finding(finding, file) for finding in faults.findings)
    found = _inspection(file, remarks, faults.description, base, faults.complete, implied=not faults.errors)
    return replace(found, remarks=tuple(map(_of_expansion, found.remarks))) if expand else found


def _inspection(
    file: str,
    remarks: Iterable[Remark],
    robot: RobotDescription | None,
    base: str | None,
    complete: bool = True,
    implied: bool = True,
) -> Inspection:
    """With what the description itself says: the reader's findings where they are not among the remarks, and doubts.

    Args:
        implied: whether the description is that of the whole file, so that its numbers are the file's.
    """
    found = dict.fromkeys(remarks)
    if robot is not None and implied:
        found |= dict.fromkeys(_of_finding(finding, file) for finding in (*robot.findings, *implausible(robot)))
    if robot is not None and base is not None and base not in (names := [link.name for link in robot.links]):
        message = f"the robot has no link {base!r}, which was named as base"
        found[Remark("error", "KS310", message, nearest(base, names), Place(file))] = None
    codes = {remark.code for remark in found}
    kept = [remark for remark in found if not (remark.code == "KS161" and "KS428" in codes)]
    kept.sort(key=lambda remark: (SEVERITIES.index(remark.severity), remark.place.file != file, remark.place))
    if robot is None:
        return Inspection(file, None, 0, 0, tuple(kept), complete=complete)
    moving = sum(joint.kind != "fixed" for joint in robot.joints)
    return Inspection(file, robot.name, len(robot.links), moving, tuple(kept), complete=complete)


def _of_error(error: Exception, file: str) -> Remark:
    if not isinstance(error, KinestaticsError):
        return Remark("error", "KS109", f"cannot be read: {error}", "", Place(file))
    return Remark("error", error.code, error.message, error.hint, error.place or Place(file))


def _of_finding(finding: Finding, file: str) -> Remark:
    severity: Severity = "note" if finding.code in NOTES else "warning"
    return Remark(severity, finding.code, finding.message, REMEDIES.get(finding.code, ""), finding.place or Place(file))


def _of_expansion(remark: Remark) -> Remark:
    """A place in what a xacro file expands to is none in the file itself."""
    if not remark.place.line:
        return remark
    message = f"{remark.message} (line {remark.place.line} of what it expands to)"
    return replace(remark, message=message, place=Place(remark.place.file))


def _is_opened(error: Exception) -> bool:
    return isinstance(error, KinestaticsError) and error.code not in _NOT_OPENED
