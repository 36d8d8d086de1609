"""RobotModel: a robot as immutable data. Floor 3. Nothing here depends on q.

A model is a tree of *moving joints*, sorted so that a parent comes before its children. Joint i carries a frame that
moves with everything behind it; links are fixed to one of these frames or to the base. All joints are unit screws,
so that no formula needs to ask for a joint's type. A mimic joint shares the column of its master.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from .errors import (
    ConfigurationError,
    Finding,
    KinestaticsWarning,
    RobotDefinitionError,
    UnknownNameError,
    nearest,
)
from .frames import BASE, TIP
from .namespaces import Array, as_array
from .surfaces import surface

_ARRAYS = ("placements", "screws", "multipliers", "offsets", "link_placements", "masses", "centers_of_mass", "inertias")


_NO_LIMIT = 1e6
"""Some files write "no limit" as a large number; from here on [rad or m] one is taken for none when sampling."""

_LARGEST = 1e50
"""Masses and lengths above this overflow once they are multiplied; no load has them."""
_SOUND = 1e-9
"""An inertia may miss symmetry, or a moment its bound, by this share of its largest entry: files are rounded."""


def _check_load(mass: Array, inertia: Array) -> None:
    """Raises RobotDefinitionError (KS324) unless a rigid body can have this mass and this inertia about its centre."""
    if mass.dtype != object and not mass > 0:
        raise RobotDefinitionError("KS324", f"payload: mass is {float(mass):g} kg", "a load has a positive mass")
    if inertia.dtype == object:
        return
    slack = _SOUND * float(np.abs(inertia).max())
    if np.abs(inertia - inertia.T).max() > slack:
        raise RobotDefinitionError(
            "KS324", "payload: inertia is not symmetric", "give ixx ixy ixz / ixy iyy iyz / ixz iyz izz"
        )
    moments = np.linalg.eigvalsh(inertia)
    if moments[0] < -slack:
        raise RobotDefinitionError(
            "KS324", "payload: inertia is not positive semidefinite", "is it about the centre of mass?"
        )
    if moments[0] + moments[1] < moments[2] - slack:
        hint = "the largest of the three moments is at most the sum of the others"
        raise RobotDefinitionError("KS324", "payload: no rigid body has this inertia (triangle inequality)", hint)


def _read_only(value: Array) -> Array:
    array = np.array(value, dtype=None if np.asarray(value).dtype == object else np.float64)
    array.setflags(write=False)
    return array


class RobotFile(NamedTuple):
    """The file that a model was read from, and what was said about it: so that it can be read again, for its shapes.

    Attributes:
        path: absolute.
        package_roots: absolute folders in which its package:// paths may be looked up.
        allow_xacro: whether the user trusts it to be expanded.
    """

    path: str
    package_roots: tuple[str, ...] = ()
    allow_xacro: bool = False


@dataclass(frozen=True, eq=False, repr=False)
class RobotModel:
    """A robot arm: names, placements, joint screws, masses and limits. Immutable; made by `load`, `from_dh`, `from_screws`.

    With m moving joints, n independent joints (columns of the Jacobian) and L links:

    Attributes:
        name: name of the robot.
        base, tip: link names; the tip is the default target of every question, None when the model has none.
        joint_names: (n) independent joints, in the order of q.
        moving_names: (m) all moving joints, mimic followers included, parents first.
        kinds: (m) "revolute", "continuous", "prismatic" or "helical", for people to read.
        parents: (m) index of the moving joint before, -1 for the base.
        placements: (m, 4, 4) joint frame at zero, seen from the parent's frame [m].
        screws: (m, 6) unit screw of the joint in its own frame, linear part first.
        columns: (m) which entry of q moves the joint.
        multipliers, offsets: (m) the joint moves by multiplier · q[column] + offset [rad or m].
        link_names, link_joints: (L) the links and the moving joint that carries each, -1 for the base.
        link_placements: (L, 4, 4) link frame seen from its joint's frame [m].
        masses: (L) [kg]; centers_of_mass: (L, 3) in link axes [m]; inertias: (L, 3, 3) about the centre of mass [kg m²].
        lower, upper: (n) position limits [rad or m], infinite where there is none.
        velocity_limits: (n) [rad/s or m/s] and effort_limits: (n) [N m or N], infinite where unknown.
        home: (n) the configuration called "home" [rad or m].
        frozen: value of each joint that was held fixed when the model was made [rad or m].
        source: where the numbers come from.
        findings: what a careful reader of the robot's file would be told.
        payloads: links that `with_payload` added.
        file: the file it was read from, None where it was not read from one.
        digest: SHA-256 of the bytes of that file, or of the catalogue's, in hexadecimal digits; files it includes aside.
        has_masses: whether any mass was given; without, gravity is an error and not a silent zero.

    Example:
        >>> import kinestatics as ks
        >>> arm = ks.load("planar_2r")
        >>> arm.joint_names
        ('joint1', 'joint2')
    """

    name: str
    base: str
    tip: str | None
    joint_names: tuple[str, ...]
    moving_names: tuple[str, ...]
    kinds: tuple[str, ...]
    parents: tuple[int, ...]
    placements: Array
    screws: Array
    columns: tuple[int, ...]
    multipliers: Array
    offsets: Array
    link_names: tuple[str, ...]
    link_joints: tuple[int, ...]
    link_placements: Array
    masses: Array
    centers_of_mass: Array
    inertias: Array
    lower: Array
    upper: Array
    velocity_limits: Array
    effort_limits: Array
    home: Array
    frozen: Mapping[str, float] = field(default_factory=dict)
    source: str = ""
    findings: tuple[Finding, ...] = ()
    payloads: tuple[str, ...] = ()
    file: RobotFile | None = None
    digest: str = ""

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, entry.name, _read_only(value))
        order = all(-1 <= parent < i for i, parent in enumerate(self.parents))
        if not order or len(set(self.link_names)) != len(self.link_names):
            raise RobotDefinitionError("KS139", "joints are not sorted parents first, or two links share a name")

    @property
    def n(self) -> int:
        """Number of independent joints: the length of q and the number of columns of the Jacobian."""
        return len(self.joint_names)

    @cached_property
    def joint_kinds(self) -> tuple[str, ...]:
        """(n) "revolute", "continuous", "prismatic" or "helical" for each independent joint."""
        kinds = dict(zip(self.moving_names, self.kinds, strict=True))
        return tuple(kinds.get(name, "revolute") for name in self.joint_names)

    @cached_property
    def is_symbolic(self) -> bool:
        """Whether lengths or angles are SymPy expressions."""
        return bool(self.placements.dtype == object)

    @cached_property
    def has_symbolic_masses(self) -> bool:
        """Whether masses or their centres are SymPy expressions; lengths may be numbers all the same."""
        return object in (self.masses.dtype, self.centers_of_mass.dtype)

    @cached_property
    def has_masses(self) -> bool:
        """Whether any link has a mass."""
        return bool(self.masses.dtype == object or np.any(self.masses > 0))

    @cached_property
    def _link_index(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.link_names)}

    def link(self, name: str) -> int:
        """Index of a link; "base" and "tip" always stand for the model's own, whatever its links are called.

        A link that happens to be called "base" or "tip" without being it is reached as "link:base" or "link:tip".

        Raises:
            UnknownNameError: KS310, with the nearest names; KS311 when the model has no tip.
        """
        if not isinstance(name, str):
            raise UnknownNameError("KS310", f"{name!r} is not the name of a link", nearest("", self.link_names))
        if name == BASE:
            return self._link_index[self.base]
        if name == TIP and (self.tip is not None or TIP not in self._link_index):
            if self.tip is None:
                raise UnknownNameError(
                    "KS311", f"robot {self.name!r} was loaded without a tip", "say at='a link', or load it with tip='a link'"
                )
            return self._link_index[self.tip]
        if (index := self._link_index.get(name.removeprefix("link:"))) is not None:
            return index
        raise UnknownNameError("KS310", f"robot {self.name!r} has no link {name!r}", nearest(name, self.link_names))

    def link_name(self, index: int) -> str:
        """The name by which `link` finds this link: its own, or "link:base" for one that only happens to be called so."""
        name = self.link_names[index]
        return name if self.link(name) == index else f"link:{name}"

    def path(self, joint: int) -> tuple[int, ...]:
        """The moving joints from the base to `joint`, itself included; () for -1."""
        found: list[int] = []
        while joint >= 0:
            found.append(joint)
            joint = self.parents[joint]
        return tuple(reversed(found))

    @cached_property
    def ancestry(self) -> Array:
        """(m, m) ones where the joint of the row is moved by the joint of the column, itself included."""
        matrix = np.zeros((len(self.parents), len(self.parents)))
        for i, parent in enumerate(self.parents):
            if parent >= 0:
                matrix[i] = matrix[parent]
            matrix[i, i] = 1.0
        return matrix

    @cached_property
    def folding(self) -> Array:
        """(m, n) matrix with q̇_moving = folding · q̇: one non-zero a row, the multiplier in the joint's column."""
        matrix = np.zeros((len(self.columns), self.n), dtype=self.multipliers.dtype)
        matrix[np.arange(len(self.columns)), list(self.columns)] = self.multipliers
        return matrix

    def map(self, function: Callable[[Array], Array]) -> RobotModel:
        """The model with `function` applied to its kinematic and mass arrays (another array library, exact numbers, ...)."""
        clone = object.__new__(RobotModel)
        for entry in fields(self):
            value = getattr(self, entry.name)
            object.__setattr__(clone, entry.name, function(value) if entry.name in _ARRAYS else value)
        return clone

    def with_home(self, home: Iterable[float]) -> RobotModel:
        """The model with another home configuration, (n) [rad or m]."""
        q = np.asarray(list(home), dtype=np.float64)
        if q.shape != (self.n,):
            raise ConfigurationError("KS303", f"home has shape {q.shape}; expected ({self.n},)")
        return replace(self, home=q)

    def with_payload(
        self,
        mass: Any,
        center: Sequence[Any] = (0.0, 0.0, 0.0),
        inertia: Any = None,
        at: str = TIP,
        name: str = "payload",
    ) -> RobotModel:
        """The model with one more massive link: a load that is held fast by a link, and that every quantity then carries.

        Args:
            mass: [kg], positive; an expression of symbols for a robot of symbols.
            center: (3) centre of mass, in the axes of `at`, from its origin [m].
            inertia: (3, 3) about that centre, in the same axes [kg m²]; default none: a point mass.
            at: link that holds the load.
            name: of the new link, whose axes are those of `at`. Several payloads need names of their own.

        Raises:
            RobotDefinitionError: KS324, no load has such a mass, centre, inertia or name.
            UnknownNameError: KS310 or KS311, no such link.

        Warns:
            KinestaticsWarning: KS325, when the masses of the arm itself are unknown; it is also among the findings.

        Example:
            >>> import kinestatics as ks
            >>> arm = ks.load("planar_2r").with_payload(10.0)
            >>> ks.gravity_torques(arm, [0, 0], gravity=(0, -9.81, 0)) - ks.gravity_torques(
            ...     ks.load("planar_2r"), [0, 0], gravity=(0, -9.81, 0))
            array([196.2,  98.1])
        """
        link = self.link(at)
        if not isinstance(name, str) or name in ("", BASE, TIP, *self.link_names) or name.startswith("link:"):
            message = f"payload: {name!r} cannot be the name of a link of robot {self.name!r}"
            raise RobotDefinitionError("KS324", message, "give a name that is not taken: name='payload2'")
        load = [self._load_part(*part) for part in (("mass", mass, ()), ("center", center, (3,)))]
        moments = self._load_part("inertia", np.zeros((3, 3)) if inertia is None else inertia, (3, 3))
        _check_load(load[0], moments)
        findings = self.findings
        if not self.has_masses:
            message = f"robot {self.name!r} has no masses of its own: gravity is that of the payload {name!r} alone"
            findings = (*findings, Finding("KS325", message))
            warnings.warn(f"KS325: {message}", KinestaticsWarning, stacklevel=2)
        return replace(
            self,
            link_names=(*self.link_names, name),
            link_joints=(*self.link_joints, self.link_joints[link]),
            link_placements=np.concatenate([self.link_placements, self.link_placements[[link]]]),
            masses=np.append(self.masses, load[0]),
            centers_of_mass=np.concatenate([self.centers_of_mass, load[1][None]]),
            inertias=np.concatenate([self.inertias, moments[None]]),
            findings=findings,
            payloads=(*self.payloads, name),
        )

    def _load_part(self, what: str, value: Any, shape: tuple[int, ...]) -> Array:
        """One number, vector or matrix of a payload: finite numbers, or symbols where the robot has symbols."""
        try:
            array, xp = as_array(value, f"payload: {what}")
        except (TypeError, ValueError):
            array, xp = np.zeros(0), None
        symbols = xp is not None and xp.name == "sympy" and (self.is_symbolic or self.masses.dtype == object)
        if xp is None or tuple(array.shape) != shape or (xp.name != "numpy" and not symbols):
            hint = "mass [kg], center (3) [m], inertia (3, 3) [kg m²]; symbols only where the robot has some"
            expected = f"expected {'a number' if not shape else f'numbers of shape {shape}'}"
            raise RobotDefinitionError("KS324", f"payload: {what} is {value!r}; {expected}", hint)
        if not symbols and not np.all(np.abs(array) < _LARGEST):
            raise RobotDefinitionError("KS324", f"payload: {what} is {value!r}", "give finite numbers")
        return array

    def random_configurations(self, count: int, seed: int) -> Array:
        """(count, n) configurations, uniform within the limits; joints without limits turn within ±π (or ±1 m).

        The same seed gives the same configurations on every machine (NumPy's PCG64).
        """
        turns = np.zeros(self.n, dtype=bool)
        for column, kind in zip(self.columns, self.kinds, strict=True):
            turns[column] |= kind != "prismatic"
        reach = np.where(turns, np.pi, 1.0)
        lower = np.where(np.abs(self.lower) < _NO_LIMIT, self.lower, -reach)
        upper = np.where(np.abs(self.upper) < _NO_LIMIT, self.upper, reach)
        lower, upper = np.minimum(lower, upper), np.maximum(lower, upper)
        if seed < 0 or count < 0:
            raise ConfigurationError("KS309", f"count {count} or seed {seed} is negative", "give whole numbers from 0 on")
        return np.random.default_rng(seed).uniform(lower, upper, (count, self.n))

    def __getstate__(self) -> dict[str, Any]:
        return {entry.name: getattr(self, entry.name) for entry in fields(self)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        for name, value in state.items():
            object.__setattr__(self, name, value)
        self.__post_init__()

    def __repr__(self) -> str:
        return f"<RobotModel {self.name!r}: {self.n} joints, base {self.base!r}, tip {self.tip!r}>"

    def _repr_html_(self) -> str:
        return str(surface("notebook").html(self))

    def __str__(self) -> str:
        """A table of the joints with their limits."""
        kind = dict(zip(self.moving_names, self.kinds, strict=True))
        lines = [f"{self.name}: {self.n} joint{'s' * (self.n != 1)} from {self.base} to {self.tip or '(no tip)'}"]
        width = max((len(name) for name in (*self.joint_names, *self.frozen)), default=5)
        for i, name in enumerate(self.joint_names):
            limits = f"[{self.lower[i]:.4g}, {self.upper[i]:.4g}]"
            lines.append(f"  {i + 1:2d} {name:{width}s}  {kind[name]:10s}  {limits}")
        for name, value in self.frozen.items():
            lines.append(f"     {name:{width}s}  held at {value:g}")
        return "\n".join(lines)
