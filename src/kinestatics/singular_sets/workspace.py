"""`workspace_section`: the outline of what an arm reaches in a half plane through axis 1, and the image of its singular set.

Law: at a place on the outline with outward normal u, every motion within the limits has u · dw <= 0, w(q) the tip's place in
the section: uᵀ ∂w/∂q_j = 0 for joints off their limits, and none of the others leads on. Off all limits that is a singular
posture of the position, and a barrier: the form u · ∂²w on the motions that do not move the tip is not positive.
Source: Haug, Luh, Adkins, Wang, "Numerical algorithms for mapping boundaries of manipulator workspaces" (1996); Bohigas,
Manubens, Ros, "A complete method for workspace boundary determination on general structure manipulators" (2012).
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..errors import ConfigurationError
from ..kinematics import configuration, jacobian
from ..model import RobotModel
from ..namespaces import Array, as_array
from ..progress import Job
from ..quantities import format_number, plain
from ..spatial import ANGULAR, LINEAR, LINEAR_ROWS
from ..tasks import Task, prismatic_columns, without_rounding
from .chart import Chart
from .components import Component
from .grid import Grid
from .outlines import Loop, covered, loops

_ON_AXIS = 1e-6
_ZERO = 1e-7  # of forms, beside the largest; of singular values, beside one reach
_INSIDE = 1e-9


@dataclass(frozen=True, eq=False)
class Outline:
    """One closed curve of the outline of a section.

    Attributes:
        points: (k, 2) in order [m]; normals: (k, 2) away from what is reached.
        postures: (k, n) the tip is there [rad or m]; NaN on the axis.
        kinds: (k) "barrier": a singular posture off all limits; "limit": a joint limit keeps the arm from going on;
            "axis": on axis 1, where the half plane ends and the workspace does not.
        encloses: whether what is reached lies inside of it; False for the rim of a void.
    """

    points: Array
    normals: Array
    postures: Array
    kinds: tuple[str, ...]
    encloses: bool


@dataclass(frozen=True, eq=False)
class SingularImage:
    """Where the tip is in postures of one component of the singular set.

    Attributes:
        component: the component; points: (k, 2) [m]; postures: (k, n) [rad or m].
        kinds: (k) "barrier": bending the arm moves the tip to one side only; "crossable": to both; "degenerate": the
            curvature does not tell, or more than one direction is lost.
    """

    component: Component
    points: Array
    postures: Array
    kinds: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class WorkspaceSection:
    """What an arm reaches with its tip, in a section.

    Attributes:
        model: the robot; link: whose origin is the tip.
        axes: names of the coordinates: ("radius", "height") from axis 1 and along it, or ("x", "y") of base.
        origin: (3) the place on axis 1 from which heights are counted, base axes [m].
        outlines: closed curves; a place is reached where it lies inside an odd number of them.
        images: of the components of the singular set; what of them is not outline lies inside.
        limits: whether joint limits were kept.
        reach: the length that tolerances are shares of [m]; tolerance: how far pieces of the outlines are from straight, in
            reaches; resolution: voids and gaps smaller than that may be missed [m].
        settled: whether there was time for all of it; seconds: what it took.

    No outline is proved: a place beyond one was not reached from many postures next to it.
    """

    model: RobotModel
    link: str
    axes: tuple[str, str]
    origin: Array
    outlines: tuple[Outline, ...]
    images: tuple[SingularImage, ...]
    limits: bool
    reach: float
    tolerance: float
    resolution: float
    settled: bool
    seconds: float

    @property
    def points(self) -> Array:
        """(k, 2) of all outlines [m]."""
        return np.concatenate([outline.points for outline in self.outlines])

    @property
    def kinds(self) -> tuple[str, ...]:
        """(k) of these points."""
        return tuple(kind for outline in self.outlines for kind in outline.kinds)

    def place(self, q: Any) -> Array:
        """(..., 2) where the tip is in the section at postures (..., n) [m].

        Example:
            >>> import kinestatics as ks
            >>> section = ks.singularities(ks.load("elbow_rrr"), "position").workspace_section(cells=24)
            >>> section.place([0.4, 0.0, 0.0]).round(3)
            array([0.85, 0.  ])
        """
        array = np.asarray(configuration(self.model, q)[0], dtype=float)
        chart = Chart.of(self.model, self.link, self.axes[0] == "radius", self.limits)
        return _metres(chart, chart.place(array / chart.travel))

    def covers(self, places: Any) -> Array:
        """(...) whether places (..., 2) of the section are reached [m].

        Example:
            >>> import kinestatics as ks
            >>> section = ks.singularities(ks.load("elbow_rrr"), "position").workspace_section(cells=24)
            >>> section.covers([[0.5, 0.0], [1.5, 0.0]])
            array([ True, False])
        """
        array = np.asarray(as_array(places, "places")[0], dtype=float)
        if array.shape[-1:] != (2,):
            raise ConfigurationError("KS303", f"places have shape {array.shape}", "(..., 2): " + ", ".join(self.axes))
        rings = [Loop(o.points, o.normals, o.postures, np.zeros(0)) for o in self.outlines]
        return covered(rings, array.reshape(-1, 2)).reshape(array.shape[:-1])

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "robot": self.model.name,
            "link": self.link,
            "axes": list(self.axes),
            "origin": plain(self.origin),
            "limits": self.limits,
            "outlines": [{"points": plain(o.points), "kinds": list(o.kinds), "encloses": o.encloses} for o in self.outlines],
            "images": [{"name": i.component.name, "points": plain(i.points), "kinds": list(i.kinds)} for i in self.images],
            "reach": plain(self.reach),
            "tolerance": self.tolerance,
            "resolution": plain(self.resolution),
            "settled": self.settled,
        }

    def __str__(self) -> str:
        where = "around axis 1" if self.axes[0] == "radius" else "in the plane"
        lines = [f"what {self.link!r} of {self.model.name!r} reaches {where}{' within limits' if self.limits else ''}:"]
        for outline in self.outlines:
            low, high = outline.points.min(0), outline.points.max(0)
            spans = ", ".join(
                f"{name} {format_number(a, self.reach)} to {format_number(b, self.reach)} m"
                for name, a, b in zip(self.axes, low, high, strict=True)
            )
            shares = [f"{outline.kinds.count(kind)} {kind}" for kind in ("barrier", "limit") if kind in outline.kinds]
            lines.append(f"  {'outline' if outline.encloses else 'void'}: {spans}")
            lines.append(f"      {len(outline.points)} points: {', '.join(shares) or 'axis'}")
        for image in self.images:
            shares = [f"{image.kinds.count(k)} {k}" for k in ("barrier", "crossable", "degenerate") if k in image.kinds]
            lines.append(f"  image of {image.component.label}: {', '.join(shares) or 'no point within limits'}")
        return "\n".join(lines if self.settled else [*lines, "  the time was up before all was found"])


class Section(NamedTuple):
    """Which section: around axis 1 or of the plane x, y; and the arguments of `SingularSet.workspace_section`."""

    around: bool
    limits: bool
    cells: int
    tolerance: float
    image: int
    seed: int


def check_section(model: RobotModel, link: str, task: Task, cells: int, tolerance: float, image: int, seed: int) -> bool:
    """Whether the section is around axis 1; False for the plane x, y.

    Raises:
        ConfigurationError: KS398 for an arm or a task that has neither, KS303 for numbers.
    """
    names = ", ".join(task.row_names)
    if not set(task.rows) <= set(LINEAR_ROWS) or task.rank < 2:
        raise ConfigurationError("KS398", f"the rows are {names}: a section is of places", "task='position'")
    J = without_rounding(model, jacobian(model, np.random.default_rng(0).uniform(-1, 1, (8, model.n)), at=link).array)
    flat = bool(np.all(J[:, LINEAR_ROWS[-1]] == 0))
    if not flat and (task.rank < len(LINEAR_ROWS)):
        hint = "task='position'; of arms that move in a plane, that is x, y"
        raise ConfigurationError("KS398", f"the rows are {names}: no section of this arm's workspace", hint)
    slides = [j for j in range(model.n) if prismatic_columns(model)[j]]
    open_ = [j for j in slides if not (np.isfinite(model.lower[j]) and np.isfinite(model.upper[j]))]
    if open_ or (not flat and first_slides(model, link)):
        what = f"joint {model.joint_names[open_[0]]!r} slides, without an end" if open_ else "the first joint slides"
        raise ConfigurationError("KS398", what, "the section is around a first axis that turns, of joints that end")
    whole = all(isinstance(x, int | np.integer) and not isinstance(x, bool) for x in (cells, image, seed))
    if not whole or cells < 8 or image < 0 or seed < 0 or not 1e-9 <= tolerance <= 0.1:
        message = f"cells {cells}, image {image}, seed {seed}, tolerance {tolerance}"
        raise ConfigurationError("KS303", message, "8 cells or more, image and seed from 0 on, a tolerance from 1e-9 to 0.1")
    return not flat


def first_slides(model: RobotModel, link: str) -> bool:
    """Whether the first joint on the way to a link does not turn about an axis alone."""
    joint = model.path(model.link_joints[model.link(link)])[0]
    v, w = model.screws[joint][LINEAR], model.screws[joint][ANGULAR]
    return bool(np.linalg.norm(w) < 0.5 or abs(float(v @ w)) > 1e-12)


def section_of(
    model: RobotModel,
    link: str,
    components: Sequence[Component],
    section: Section,
    job: Job,
) -> WorkspaceSection:
    """The section of an arm's workspace.

    Args:
        model, link, components: of its singular set in the position task; section: which, and how closely.
        job: the time it may take.
    """
    began = time.monotonic()
    chart = Chart.of(model, link, section.around, section.limits)
    rng = np.random.default_rng(section.seed)
    job.tell("outline of the workspace")
    grid = Grid.of(chart, section.cells, rng)
    grid.flood(job.within(0.5))
    found, settled = loops(grid, section.tolerance, rng, job)
    images = tuple(_image(chart, component, section.image, rng) for component in components if section.image)
    names = ("radius", "height") if section.around else ("x", "y")
    outlines = tuple(_outline(chart, loop) for loop in found)
    sizes = (section.limits, chart.length, section.tolerance, grid.step * chart.length)
    seconds = time.monotonic() - began
    return WorkspaceSection(model, link, names, chart.origin, outlines, images, *sizes, settled and not job.late, seconds)


def _metres(chart: Chart, w: Array) -> Array:
    return w * chart.length if chart.around else w * chart.length + chart.origin[:2]


def _outline(chart: Chart, loop: Loop) -> Outline:
    on_axis = loop.on_axis | ((loop.points[:, 0] < _ON_AXIS) & chart.around)
    presses = chart.presses(loop.postures, loop.normals)
    kinds = np.where(on_axis, "axis", np.where(presses, "limit", "barrier"))
    postures = np.where(on_axis[:, None], np.nan, loop.postures * chart.travel)
    x, z = loop.points.T
    area = float((x * np.roll(z, -1) - z * np.roll(x, -1)).sum())
    return Outline(_metres(chart, loop.points), loop.normals, postures, tuple(kinds.tolist()), area > 0)


def _image(chart: Chart, component: Component, count: int, rng: Any) -> SingularImage:
    """The tip's places at random postures of a component, moved onto it from within the limits."""
    start = chart.random(count, rng) * chart.travel
    q, solved = component.projected(start, wrap=False)
    inside = np.all((q / chart.travel >= chart.lower - _INSIDE) & (q / chart.travel <= chart.upper + _INSIDE), axis=-1)
    y = q[solved & inside] / chart.travel
    w = chart.place(y)
    return SingularImage(component, _metres(chart, w), y * chart.travel, image_kinds(chart, y))


def image_kinds(chart: Chart, y: Array) -> tuple[str, ...]:
    """(k) the kind of singular postures y (k, n), by the form of the direction lost on the motions that hold the tip."""
    if not len(y):
        return ()
    _, J, H = chart.slopes(y)
    U, sigma, Vt = np.linalg.svd(J)
    form = np.einsum("kc,kcij->kij", U[..., -1], H)
    kernel = Vt[:, 1:, :]
    form = kernel @ form @ np.swapaxes(kernel, -1, -2)
    values = np.linalg.eigvalsh(form)
    size = np.maximum(np.abs(H).max(axis=(1, 2, 3)), 1e-12)[:, None]
    up, down = (values > _ZERO * size).any(-1), (values < -_ZERO * size).any(-1)
    simple = sigma[:, 0] > _ZERO
    simple &= (not chart.around) | (chart.place(y)[:, 0] > _ON_AXIS)
    kinds = np.where(~simple | ~(up | down), "degenerate", np.where(up & down, "crossable", "barrier"))
    return tuple(kinds.tolist())
