"""`singularities`: where an arm is singular, as equations in its joints and lengths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import ConfigurationError, UnknownNameError, nearest
from ..model import RobotModel
from ..namespaces import Array
from ..progress import Job, Progress
from ..statics import RANK_TOLERANCE
from ..surfaces import surface
from ..symbolic.functions import WaveFunction
from ..symbolic.printing import shortest
from ..tasks import Task
from .aspects import Aspects, box_of, count_aspects
from .card import Card, card_of
from .certificate import Certificate, certify, certify_path, checked_corners
from .components import Component, spectrum
from .distance import Distance
from .enclosure import Domain
from .equations import DIGITS, Equation, Space, digits_of
from .exclusion import Exclusion
from .nearest import nearest_posture
from .reach import on_boundary
from .second_order import second_order
from .text import data_of, text_of
from .tracing import Curve, Cusp, cusps_of, trace
from .workspace import Section, WorkspaceSection, check_section, section_of


@dataclass(frozen=True, eq=False, repr=False)
class SingularSet:
    """The singular set of an arm for a task.

    Attributes:
        model: the robot in its nominal numbers; link: whose motion it is; task: the rows in play and their rank.
        constant: what of the determinant is the same at all postures; None where J is not square.
        factors: its equations with multiplicities, those without real zeros included.
        components: the parts of the singular set that have real points: where all equations of one hold, rank is lost.
        candidates: these and all that samples alone left out: what `certify_free` excludes. With `components` they are the
            same set of postures.
        complete: whether the candidates are all there is: an exact covering of the singular postures. False where time ran
            out. That no component is missing beside them is then borne out by samples.
        lengths: what the symbols of the formulas stand for [m].
        residual: how far the nominal Jacobian is from that of the robot as given, at most, over random configurations;
            lengths in shares of the reach.
        seconds: what it took.
        space, polynomial: what the equations are written in, and the determinant there.

    Example:
        >>> import kinestatics as ks
        >>> print(ks.singularities(ks.load("ur5e")))
        singularities of 'ur5e': vx, vy, vz, wx, wy, wz (rank 6)
        det J = -a2*a3*(a2*cos(q2) + a3*cos(q2 + q3) - d5*sin(q2 + q3 +
                q4))*sin(q3)*sin(q5)
          shoulder: a2*cos(q2) + a3*cos(q2 + q3) - d5*sin(q2 + q3 + q4) = 0
              rank 5, takes 1; 24 of 24 points lose rank
          elbow: sin(q3) = 0  (q3 = 0°, 180°)
              rank 5, takes 1; 24 of 24 points lose rank
          wrist: sin(q5) = 0  (q5 = 0°, 180°)
              rank 5, takes 1; 24 of 24 points lose rank
          with a2 = 0.425, a3 = 0.3922, d4 = 0.1333, d5 = 0.0997, d6 = 0.0996 m
    """

    model: RobotModel
    link: str
    task: Task
    constant: Any
    factors: tuple[tuple[Equation, int], ...]
    components: tuple[Component, ...]
    candidates: tuple[Component, ...]
    complete: bool
    lengths: Mapping[Any, Any]
    residual: float
    seconds: float
    space: Space
    polynomial: Any

    @property
    def never(self) -> bool:
        """Whether the arm is never singular in this task, proved: no factor has real zeros."""
        decided = all(equation.real is False for equation, _ in self.factors)
        return self.complete and not self.candidates and decided

    @cached_property
    def determinant(self) -> Any:
        """SymPy, factored, in axes in which it is shortest (it is the same in all); None where J is not square."""
        import sympy

        if self.constant is None:
            return None
        number = self.constant
        for equation, times in self.factors:
            number *= equation.scale**times
        leading = shortest(self.space.half, number)
        if leading.is_Rational and digits_of(number) > DIGITS:
            leading = sympy.Float(leading)
        return sympy.Mul(leading, *[equation.expression**times for equation, times in self.factors])

    @cached_property
    def fourier(self) -> WaveFunction:
        """The determinant as a sum of waves in numbers: `frequencies`, `cosines`, `sines`; value, gradient and Hessian.

        Raises:
            ConfigurationError: KS398 where there is no determinant, or lengths have no numbers.

        Law: det J(q) = Σ_k cosines_k cos(frequencies_k · q) + sines_k sin(frequencies_k · q), times powers of slides.

        Example:
            >>> import kinestatics as ks
            >>> f = ks.singularities(ks.load("planar_2r")).fourier
            >>> f.frequencies.tolist(), f.sines.tolist()
            ([[0.0, 1.0]], [1.0])
        """
        if self.polynomial is None:
            raise ConfigurationError(
                "KS398", "J is not square: there is no determinant", "task= with as many rows as joints"
            )
        self._exact_lengths()
        return WaveFunction.of(self.space.half, self.polynomial, self.space.values)

    def on(self, q: Any, tolerance: float = 1e-9) -> tuple[Component, ...]:
        """The components on which a configuration (n) lies, its equations held to a share of their amplitudes."""
        array = self._configuration(q)
        held = (np.abs(c.residuals(array[None])[0]).max() for c in self.components)
        return tuple(c for c, rest in zip(self.components, held, strict=True) if rest <= tolerance)

    def at(self, q: Any, *, boundary: bool = False, tolerance: float = RANK_TOLERANCE) -> Card:
        """The card of a posture (n): what it is, what is lost, what is held for free, its class, and how near others are.

        Args:
            q: [rad or m].
            boundary: whether to look over other branches if the tip is on the boundary of the workspace (up to 5 s).
            tolerance: singular values below this fraction of the largest count as zero.

        Example:
            >>> import kinestatics as ks
            >>> card = ks.singularities(ks.load("planar_2r")).at([0.3, 0.0])
            >>> card.on, card.second_order.kind
            (('elbow',), 'barrier')
        """
        array = self._configuration(q)
        self._exact_lengths()
        sigma = spectrum(self.model, array, self.task, self.link)
        singular = bool((sigma > tolerance).sum() < self.task.rank)
        on = tuple(dict.fromkeys(component.label for component in self.on(array, 1e-8))) if singular else ()
        second = second_order(self.model, array, self.task, self.link, tolerance) if singular else None
        reach = None
        if second is not None and boundary and second.kind != "regular":
            reach = on_boundary(self.model, second.q, self.task, self.link, second)
        near = self.distance(array)
        card = card_of(self.model, self.link, self.task, array, on, near, second, reach, tolerance, self.residual)
        return replace(card, complete=self.complete)

    def distance(self, q: Any, *, within_limits: bool = False) -> tuple[Distance, ...]:
        """The distance of a posture (n) from every component, the nearest first.

        Where the set is not `complete`, of the components that are known: others may be nearer.

        Args:
            q: [rad or m]; it may be outside the limits.
            within_limits: whether to look for the nearest postures inside the joint limits, where the arm can go; without,
                limits are not looked at.

        Returns:
            A `Distance` for each component: `nearest` is None where no posture was found.

        Example:
            >>> import kinestatics as ks
            >>> found = ks.singularities(ks.load("puma_560")).distance([0, 0.4, -1.0, 0.5, 0.3, 0.2])
            >>> print(found[0])
            wrist: 0.3 rad (17.1887°), at least 0.3
        """
        array = self._configuration(q)
        self._exact_lengths()
        found = (nearest_posture(component, array, within_limits) for component in self.components)
        return tuple(sorted(found, key=lambda d: d.value))

    def certify_free(
        self, box: Any = None, *, path: Any = None, budget: float = 2.0, progress: Progress | None = None
    ) -> Certificate:
        """Whether a box of postures, or a path of straight pieces, is free of singularities, as a proof.

        Args:
            box: (2, n) lower and upper corner, or a pair of them [rad, m where joints slide].
            path: (m, n) postures, m >= 2, joined by straight lines in the joints. One of the two.
            budget: [s] for each box or piece of the path; math.inf for no end.
            progress: told now and then what is being looked at, and which share of the path is done.

        Returns:
            Certificate: "free" is proved for the nominal robot, all rounding accounted for; "singular" has a witness;
            "undecided" is neither. Of a path, the worst piece; what lies behind a singular one is not looked at.

        Raises:
            ConfigurationError: KS303 for shapes, KS353 for a budget that is none, KS398 where lengths have no numbers.

        Law: a component is absent from a piece where one of its equations f has |f(c)| > Σ h_i |∂f/∂q_i(c)| + ½ hᵀ H h, with
        c the centre, h the half widths and H a bound of the second derivatives; others are halved.

        Example:
            >>> import kinestatics as ks
            >>> found = ks.singularities(ks.load("puma_560"))
            >>> found.certify_free(([0, 0.3, 0.4, 0.1, 0.2, 0], [0.1, 0.4, 0.5, 0.2, 0.3, 0.1])).verdict
            'free'
        """
        corners = checked_corners(self.model.n, box, path)
        self._exact_lengths()
        if box is None:
            proof = certify_path(self._exclusion, corners, budget, progress)
        else:
            proof = certify(self._exclusion, Domain.of_box(*corners), Job.of(budget, progress))
        return replace(proof, residual=self.residual)

    @cached_property
    def _exclusion(self) -> Exclusion:
        """What certificates read, made once."""
        return Exclusion(self.candidates, self.space)

    def trace(self, joints: Sequence[str | int], q: Any = None, step: float = 0.02) -> tuple[Curve, ...]:
        """The singular curves in the plane of two joints, for drawing.

        Args:
            joints: names or columns of two joints.
            q: (n) where the others are held; default the home posture.
            step: between points [rad or m].

        Raises:
            ConfigurationError: KS303 for joints that are not two; KS398 where a component takes more than one equation.

        Example:
            >>> import kinestatics as ks
            >>> curves = ks.singularities(ks.load("puma_560")).trace(["joint2", "joint3"])
            >>> sorted({curve.component.name for curve in curves})
            ['elbow', 'shoulder']
        """
        self._exact_lengths()
        columns = [self._column(joint) for joint in joints]
        if len(columns) != 2 or columns[0] == columns[1]:
            raise ConfigurationError("KS303", f"joints are {joints!r}", "two different joints")
        if any(len(component.equations) > 1 for component in self.components):
            hint = "their points are in `components[i].points`"
            raise ConfigurationError("KS398", "a component of several equations is no curve in a plane", hint)
        held = self.model.home if q is None else self._configuration(q)
        in_plane = [c for c in self.components if set(c.columns) & set(columns)]
        return tuple(curve for c in in_plane for curve in trace(c, (columns[0], columns[1]), held, checked_positive(step)))

    def cusps(self, step: float = 0.02) -> tuple[Cusp, ...]:
        """The cusps of an arm with three joints that turn: postures where three solutions of the inverse problem meet.

        Args:
            step: between the points of the singular curves along which they are looked for [rad].

        Raises:
            ConfigurationError: KS398 for other arms.

        Example:
            >>> import kinestatics as ks
            >>> len(ks.singularities(ks.load("elbow_rrr"), "position").cusps())
            0
        """
        fits = self.model.n == 3 and self.task.rank == 3 and self.polynomial is not None and all(self.space.half.ring.turns)
        if not fits:
            raise ConfigurationError("KS398", "cusps are of three joints that turn and a task of rank 3", "task='position'")
        self._exact_lengths()
        if any(0 in c.columns for c in self.components):
            raise ConfigurationError("KS398", "the first joint changes the determinant of these rows", "task='position'")
        found = (cusps_of(c, self.model, self.task, self.link, checked_positive(step)) for c in self.components)
        return tuple(cusp for cusps in found for cusp in cusps)

    def _column(self, joint: str | int) -> int:
        if isinstance(joint, str) and joint in self.model.joint_names:
            return self.model.joint_names.index(joint)
        if isinstance(joint, int) and 0 <= joint < self.model.n:
            return joint
        raise UnknownNameError("KS313", f"there is no joint {joint!r}", nearest(str(joint), self.model.joint_names))

    def aspects(
        self,
        starts: int = 600,
        seed: int = 0,
        *,
        limits: bool = False,
        budget: float = 60.0,
        progress: Progress | None = None,
    ) -> Aspects:
        """The regions of joint space that singular postures separate.

        Args:
            starts: postures from which each round looks for regions and for ways between them; more find more.
            seed: of these postures.
            limits: whether to count the regions within the joint limits, where a joint with more than a whole turn comes to
                the same place in different regions; without, all joints turn freely.
            budget: [s] after which what is found is handed back; progress: told of the rounds.

        Returns:
            Aspects: the count, a posture and the sign of each, and what of it is proved.

        Raises:
            ConfigurationError: KS398 where there is no determinant, lengths have no numbers, or a joint slides: without
            limits any, with limits one that has none. KS353 for a budget that is no positive number.

        Example:
            >>> import kinestatics as ks
            >>> found = ks.singularities(ks.load("puma_560"))
            >>> found.aspects().count, found.aspects(limits=True).count
            (8, 16)
        """
        job = Job.of(budget, progress)
        f = self.fourier
        box = box_of(self.model, self.space.half.ring.turns, f.joints, limits)
        return count_aspects(self.factors, f, self.space, box, starts, seed, job)

    def workspace_section(
        self,
        *,
        limits: bool = True,
        cells: int = 64,
        tolerance: float = 1e-5,
        image: int = 400,
        seed: int = 0,
        budget: float = 60.0,
        progress: Progress | None = None,
    ) -> WorkspaceSection:
        """What the tip reaches in the half plane through axis 1: its outline with voids, and the image of the singular set.

        Of an arm that moves in the plane x, y, that plane. Angles of joint 1 are left out: where it cannot turn all around,
        the section is that of the sector it sweeps.

        Args:
            limits: whether joint limits are kept; without, joints turn freely, and those that slide keep theirs.
            cells: of the grid along the longer side, on which the outline is looked for: what is smaller may be missed.
            tolerance: how far the outline may be from the pieces between its points, in reaches.
            image: postures of each component of which the tip's place is given; 0 for none.
            seed: of random postures; budget: [s] after which what is found is handed back; progress: told of the rounds.

        Returns:
            WorkspaceSection. Its outline is as far as many postures say: no place beyond was reached, which is no proof.

        Raises:
            ConfigurationError: KS398 where the task is not the position, the first joint slides, another one slides without
            limits, or lengths have no numbers; KS303, KS353 for arguments.

        Example:
            >>> import kinestatics as ks
            >>> found = ks.singularities(ks.load("elbow_rrr"), "position")
            >>> section = found.workspace_section(cells=24, image=60)
            >>> section.points.max(axis=0).round(3), sorted(set(section.kinds))
            (array([0.85, 0.85]), ['axis', 'barrier'])
        """
        self._exact_lengths()
        around = check_section(self.model, self.link, self.task, cells, tolerance, image, seed)
        job = Job.of(budget, progress)
        section = Section(around, limits, cells, tolerance, image, seed)
        return section_of(self.model, self.link, self.components, section, job)

    def _exact_lengths(self) -> dict[Any, Any]:
        """Exact numbers of the symbols.

        Raises:
            ConfigurationError: KS398 where there are none.
        """
        if not self.space.given:
            raise ConfigurationError("KS398", "the lengths have no numbers", "singularities(model, lengths={...})")
        return self.space.exact

    def _configuration(self, q: Any) -> Array:
        array = np.array(q, dtype=float)
        if array.shape != (self.model.n,) or not np.all(np.isfinite(array)):
            raise ConfigurationError("KS303", f"q is {q!r}", f"one configuration of {self.model.n} finite numbers")
        return array

    def to_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return data_of(self)

    def _repr_html_(self) -> str:
        return str(surface("notebook").html(self))

    def __str__(self) -> str:
        return text_of(self)

    def __repr__(self) -> str:
        return str(self)


def checked_positive(step: Any) -> float:
    """A step of a walk, positive and finite.

    Raises:
        ConfigurationError: KS353.
    """
    if not (isinstance(step, int | float) and 0 < step < 1):
        raise ConfigurationError("KS353", f"step is {step!r}", "a positive number below 1, in rad or m")
    return float(step)
