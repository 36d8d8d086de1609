"""Components of the singular set: equations that hold together, the freedoms they take, and what samples say."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..kinematics import jacobian
from ..model import RobotModel
from ..namespaces import Array
from ..progress import Job
from ..quantities import plain
from ..spatial import ANGULAR_ROWS
from ..symbolic.branches import Branch
from ..symbolic.functions import WaveFunction
from ..symbolic.halfangle import HalfAngleRing
from ..tasks import Task, characteristic_length, without_rounding
from .equations import Equation, Space, together
from .names import name_of

SAMPLES = 24
_STEPS, _ON = 60, 1e-13
_DROPS = 1e-9
_RANK = 1e-6
_CHOICES, _SAME = 40, 1e-9
_GENERAL = 8
_NAMED = 6  # points by which a component is named


@dataclass(frozen=True, eq=False)
class Component:
    """One component of the singular set.

    Attributes:
        equations: all of them hold on it.
        multiplicity: of the factor in the determinant; None where there is no determinant.
        others: products of factors that vanish besides, where splitting them ended for want of time.
        task: rows and rank that drops; at: the link.
        space: what it is written in.
    """

    equations: tuple[Equation, ...]
    task: Task
    at: str
    space: Space
    multiplicity: int | None = None
    others: tuple[tuple[Equation, ...], ...] = ()

    @cached_property
    def name(self) -> str:
        """ "wrist", "elbow", "shoulder" by the geometry of its postures, two joined by "and", or "other" where none fits."""
        return name_of(self.space.model, self.points[:_NAMED], self.joints, self.at, self.task)

    @property
    def label(self) -> str:
        """The name, and for "other" the joints it is of."""
        return self.name if self.name != "other" else f"{self.name} ({', '.join(self.joints)})"

    @cached_property
    def columns(self) -> tuple[int, ...]:
        """The joints it depends on, from 0."""
        return tuple(sorted({j for equation in self.equations for j in equation.columns}))

    @property
    def joints(self) -> tuple[str, ...]:
        """Their names."""
        return tuple(self.space.model.joint_names[j] for j in self.columns)

    @property
    def split(self) -> bool:
        """Whether it is described by its equations alone."""
        return not self.others

    @cached_property
    def points(self) -> Array:
        """(k, n) configurations on it, found from random ones; empty where none was found."""
        q = self.space.random(4 * SAMPLES, seed=3)
        found, solved = self.projected(q)
        return found[solved][:SAMPLES]

    def projected(self, q: Array, wrap: bool = True) -> tuple[Array, Array]:
        """(k, n) the configurations moved onto it by Gauss-Newton steps, angles in (-π, π], and (k) whether they arrived."""
        q = np.array(q, dtype=float)
        for _ in range(_STEPS):
            values, slopes = self.residuals(q)
            q = q - np.einsum("kij,kj->ki", np.linalg.pinv(slopes, rcond=1e-9), values)
        if wrap:
            turns = np.array(self.space.half.ring.turns, dtype=bool)
            q = np.where(turns, np.pi - np.mod(np.pi - q, 2 * np.pi), q)
        return q, np.abs(self.residuals(q)[0]).max(-1) <= _ON

    def residuals(self, q: Array) -> tuple[Array, Array]:
        """(k, e) values of the equations in shares of their amplitudes, and (k, e, n) their gradients."""
        found = [self._nearest_parts(group, q, 1) for group in self._groups]
        return np.stack([values for values, _ in found], -1), np.stack([slopes for _, slopes in found], -2)

    def curvatures(self, q: Array) -> Array:
        """(k, e, n, n) second derivatives of the equations in shares of their amplitudes."""
        return np.stack([self._nearest_parts(group, q, 2)[1] for group in self._groups], -3)

    @property
    def _groups(self) -> list[list[WaveFunction]]:
        """Functions of each condition, one of which vanishes."""
        groups = [[equation] for equation in self.equations] + [list(group) for group in self.others]
        return [[f for equation in group for f in equation.functions] for group in groups]

    @staticmethod
    def _nearest_parts(functions: list[WaveFunction], q: Array, order: int) -> tuple[Array, Array]:
        """(k) value of the function nearest to zero at each q, and its first or second derivatives."""
        values = np.stack([f.value(q) / f.scale for f in functions])
        nearest = np.abs(values).argmin(0)
        derived = np.stack([(f.gradient(q) if order == 1 else f.hessian(q)) / f.scale for f in functions])
        here = np.arange(len(q))
        return values[nearest, here], derived[nearest, here]

    @cached_property
    def codimension(self) -> int | None:
        """How many freedoms it takes, by the rank of its equations' gradients at its points; None without a point."""
        if not len(self.points):
            return None
        sigma = np.linalg.svd(self.residuals(self.points)[1], compute_uv=False)
        return int(np.median((sigma > _RANK * sigma.max()).sum(-1)))

    @cached_property
    def rank(self) -> int | None:
        """Rank of the task's rows at almost every point of it; None without a point."""
        if not len(self.points):
            return None
        return int((spectrum(self.space.model, self.points, self.task, self.at) > _DROPS).sum(-1).max())

    @cached_property
    def verified(self) -> str:
        """What samples say: "24 of 24 points lose rank"; "no real point found in 96 tries"."""
        if not len(self.points):
            return f"no real point found in {4 * SAMPLES} tries"
        sigma = spectrum(self.space.model, self.points, self.task, self.at)
        lost = int((sigma[:, self.task.rank - 1] <= _DROPS).sum())
        return f"{lost} of {len(self.points)} points lose rank"

    @property
    def sound(self) -> bool:
        """Whether every sampled point loses rank."""
        return len(self.points) > 0 and self.verified.startswith(f"{len(self.points)} of")

    @cached_property
    def within_limits(self) -> bool | None:
        """Whether it has points inside the joint limits: True; False where one joint decides; None if none was found."""
        model, decided = self.space.model, True
        for equation in self.equations:
            if equation.solutions is not None and not equation_within(equation, model):
                return False
            decided = decided and equation.solutions is not None
        if decided:
            return True
        q, solved = self.projected(model.random_configurations(8 * SAMPLES, seed=4))
        inside = np.all((q >= model.lower - 1e-9) & (q <= model.upper + 1e-9), axis=-1)
        return True if np.any(solved & inside) else None

    def text(self) -> str:
        """The equations, one after the other."""
        text = " and ".join(equation.text() for equation in self.equations)
        return text + (f" and {len(self.others)} products of factors that were not split" if self.others else "")

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "name": self.name,
            "equations": [str(equation.expression) for equation in self.equations],
            "joints": list(self.joints),
            "solutions": [plain(np.array(e.solutions)) if e.solutions is not None else None for e in self.equations],
            "codimension": self.codimension,
            "multiplicity": self.multiplicity,
            "rank": self.rank,
            "verified": self.verified,
            "within_limits": self.within_limits,
            "split": self.split,
        }

    def __str__(self) -> str:
        return f"{self.name}: {self.text()}"


def spectrum(model: RobotModel, q: Array, task: Task, at: str) -> Array:
    """(..., k) singular values of the task's rows, radians in reaches of the arm, relative to the largest there is.

    The largest of the posture, or of others where the rows hold less: with one row, that may be none.
    """
    size = characteristic_length(model, at)
    weights = np.array([size if r in ANGULAR_ROWS else 1.0 for r in task.rows])

    def singular_values(postures: Array) -> Array:
        J = without_rounding(model, jacobian(model, postures, at=at, check_finite=False).array)
        return np.linalg.svd(weights[:, None] * J[..., list(task.rows), :], compute_uv=False)

    sigma = singular_values(q)
    general = np.median(singular_values(np.random.default_rng(9).uniform(-np.pi, np.pi, (_GENERAL, model.n)))[:, :1])
    return sigma / np.maximum(np.maximum(sigma[..., :1], 1e-3 * general), np.finfo(float).tiny)


def equation_within(equation: Equation, model: RobotModel) -> bool:
    """Whether a joint can take a value at which an equation of that joint holds."""
    j = equation.columns[0]
    turns = equation.space.half.ring.turns[j]
    for value in equation.solutions or ():
        shifts = 2 * np.pi * np.arange(-2, 3) if turns else np.zeros(1)
        if np.any((value + shifts >= model.lower[j] - 1e-9) & (value + shifts <= model.upper[j] + 1e-9)):
            return True
    return False


def components_of(
    branches: Sequence[Branch], space: Space, task: Task, at: str, job: Job
) -> tuple[list[Component], list[Component], bool]:
    """Branches as components: halves of sines joined, those without real points and those inside others left out.

    Returns:
        These, and before anything was left out on the word of samples, all that may hold a singular posture: what a proof
        has to exclude; and whether there was time for all of them.
    """
    joined = _joined(list(branches), space.half)
    found = []
    for equations, others in joined:
        parts = tuple(Equation(parts, space) for parts in equations)
        rest = tuple(tuple(Equation((F,), space) for F in condition) for condition in others)
        component = Component(parts, task, at, space, others=rest)
        if all(equation.real is not False for equation in parts):
            found.append(component)
    real: list[Component] = []
    for place, component in enumerate(found):
        job.tell("points of components", place / len(found))
        if job.late:
            return _outermost(real), found, False
        if len(component.points):
            real.append(component)
    return [_shortened(component) for component in _outermost(real)], found, True


def _shortened(component: Component) -> Component:
    """The same component by fewer equations: those that hold wherever some others do, at all sampled points, are left out.

    The short list is kept only where its points are no more than those of the long one.
    """
    freedoms = component.codimension
    if freedoms is None or component.others or len(component.equations) <= freedoms:
        return component
    ordered = sorted(component.equations, key=lambda e: len(e.parts[0].to_dict()))
    for chosen in itertools.islice(itertools.combinations(ordered, freedoms), _CHOICES):
        shorter = replace(component, equations=chosen)
        if len(shorter.points) and np.abs(component.residuals(shorter.points)[0]).max() <= _SAME:
            return shorter
    return component


Parts = tuple[Any, ...]


def _joined(branches: list[Branch], half: HalfAngleRing) -> list[tuple[tuple[Parts, ...], tuple[Any, ...]]]:
    """Branches that differ in one equation only, sin(x/2) here and cos(x/2) there, as one."""
    state = [([(F,) for F in branch.equations], branch.others) for branch in branches]
    merged = True
    while merged:
        merged = False
        for i in range(len(state)):
            for k in range(i + 1, len(state)):
                both = _one_different(state[i], state[k], half)
                if both is not None:
                    state[i] = both
                    del state[k]
                    merged = True
                    break
            if merged:
                break
    return [(tuple(equations), others) for equations, others in state]


def _one_different(a: Any, b: Any, half: HalfAngleRing) -> Any:
    if len(a[0]) != len(b[0]) or str(a[1]) != str(b[1]):
        return None
    own, other = ({str(sorted(map(str, parts))): parts for parts in x[0]} for x in (a, b))
    left, right = [k for k in own if k not in other], [k for k in other if k not in own]
    if len(left) != 1 or len(right) != 1:
        return None
    F, G = own[left[0]], other[right[0]]
    if len(F) != 1 or len(G) != 1 or not together(F[0], G[0], half):
        return None
    return [*(parts for key, parts in own.items() if key != left[0]), (F[0], G[0])], a[1]


def _outermost(components: list[Component]) -> list[Component]:
    """Without components all of whose points lie on another one that takes fewer freedoms, or as many by fewer equations."""
    kept: list[Component] = []
    order = sorted(components, key=lambda c: (c.codimension or 0, len(c.equations), len(c.columns)))
    for component in order:
        inside = any(np.abs(other.residuals(component.points)[0]).max() <= 1e-9 for other in kept)
        if not inside:
            kept.append(component)
    return kept
