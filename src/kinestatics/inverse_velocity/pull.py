"""`Pull`: small steps towards a place, inside the position limits, out of singular postures where there is a way out.

Each step is a resolved rate: min |J x - e|² + λ² |x|² in the box of position limits, e what is missing to the place. The
damping λ² follows |e| and vanishes with it, so that the last steps are those of Gauss and Newton (Levenberg, 1944;
Fan, Yuan, Computing 74 (2005), for λ² = |e|). Steps longer than allowed are shortened, which keeps their direction.
Where such steps lead no nearer, the curvature of |e|²/2 decides: a direction in which it falls is a way out (a stretched
elbow bends); where there is none, the arm is as near as it gets from here.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..namespaces import Array
from .box import least_in_box
from .tip_map import Place, TipMap, length_of

_STRONGEST, _WEAKEST = 0.01, 1e-3  # λ² where much is missing, in squares of the characteristic length; least share of it
_TRIALS, _STRONGER = 14, 4.0  # how often a step that leads no nearer is damped more, and by how much
_STANDS, _SLOW = 1e-6, 0.5  # relative gain of a step below which the arm stands; share that is left by slow steps
_EXACT = 1e-3  # of the tolerance: what the last steps aim for
_PRESSES = 1e-6  # a slope above this share of what is missing presses a joint against its limit
_FALLS = 1e-4  # times what is missing: a curvature below minus this leads nearer


class Here(NamedTuple):
    """A posture and what is missing to the place, in the rows in play."""

    q: Array
    missing: Array

    @property
    def size(self) -> float:
        """|e|."""
        return length_of(self.missing)


class Pull(NamedTuple):
    """One place that is pulled to, and what is kept on the way."""

    of: TipMap
    goal: Place
    lower: Array
    upper: Array
    step: float
    tolerance: float
    angle_tolerance: float

    def near(self, missing: Array, share: float = 1.0) -> bool:
        """Whether what is missing is within a share of the tolerances."""
        distance, angle = self.of.left(missing)
        return distance <= share * self.tolerance and angle <= share * self.angle_tolerance

    def followed(self, q: Array, most_steps: int) -> tuple[list[Array], str]:
        """The postures on the way, and what ended it: "reached", "steps", "minimum" or "saddle"."""
        here = Here(q, self.of.missing(q, self.goal))
        path, damping, slow = [q], 1.0, False
        while not self.near(here.missing, _EXACT):
            if len(path) > most_steps:
                return path, "reached" if self.near(here.missing) else "steps"
            further, damping = self.straight(here, damping, slow)
            if further is None or further.size > (1.0 - _STANDS) * here.size:
                if self.near(here.missing):
                    return path, "reached"
                further, saddle = self.around(here)
                if further is None:
                    return path, "saddle" if saddle else "minimum"
            slow = further.size > _SLOW * here.size
            here = further
            path.append(here.q)
        return path, "reached"

    def bounds(self, q: Array) -> tuple[Array, Array]:
        """The limits; a joint beyond one has its own place for a limit."""
        return np.minimum(self.lower, q), np.maximum(self.upper, q)

    def straight(self, here: Here, damping: float, slow: bool) -> tuple[Here | None, float]:
        """The next posture by a damped step, and the damping for the one after; None where no step leads nearer.

        Where steps have become slow, they are those of Newton for |e|²/2, its curvature made positive, and joints that are
        pressed against a limit stay there.
        """
        J, travel = self.of.jacobian(here.q), self.of.travel
        G, g, eye = J.T @ J, J.T @ here.missing, np.eye(len(here.q))
        lower, upper = self.bounds(here.q)
        room = (lower - here.q) / travel, (upper - here.q) / travel
        if slow:
            free = ~self.pressed(here)
            both = np.outer(free, free)
            G = np.where(both, self.curvature(here, J), G * eye)
            G -= min(0.0, 2.0 * float(np.linalg.eigvalsh(np.where(both, G, 0.0)).min())) * np.diag(free)
            g = np.where(free, g, 0.0)
        for _ in range(_TRIALS):
            damped = G + damping * min(here.size, _STRONGEST) * eye
            q = np.clip(here.q + travel * self.shortened(damped, g, *room), lower, upper)
            if np.array_equal(q, here.q):
                break
            further = Here(q, self.of.missing(q, self.goal))
            if further.size < here.size:
                return further, max(damping / _STRONGER, _WEAKEST)
            damping *= _STRONGER
        return None, 1.0

    def shortened(self, G: Array, g: Array, lower: Array, upper: Array) -> Array:
        """The damped step, as much of it as `step` allows, bent only where position limits ask for it."""
        whole = np.linalg.solve(G, g)
        most = float(np.abs(self.of.travel * whole).max(initial=0.0))
        share = min(1.0, self.step / most) if most > 0 else 1.0
        wanted = share * whole
        if np.all(wanted >= lower) and np.all(wanted <= upper):
            return np.asarray(wanted)
        reach = self.step / self.of.travel
        return least_in_box(G, share * g, np.maximum(lower, -reach), np.minimum(upper, reach))

    def pressed(self, here: Here) -> Array:
        """(n) whether a joint is at a limit and would go further out."""
        slope = self.of.jacobian(here.q).T @ here.missing
        lower, upper = self.bounds(here.q)
        least = _PRESSES * here.size
        return np.asarray(((here.q >= upper) & (slope > least)) | ((here.q <= lower) & (slope < -least)))

    def around(self, here: Here) -> tuple[Here | None, bool]:
        """A posture nearer to the place along the direction in which |e|²/2 falls most; and whether there is such one."""
        free = np.flatnonzero(~self.pressed(here))
        if not len(free):
            return None, False
        curvature = self.curvature(here, self.of.jacobian(here.q))[np.ix_(free, free)]
        values, vectors = np.linalg.eigh(curvature)
        if not values[0] < -_FALLS * here.size:
            return None, False
        direction = np.zeros(len(here.q))
        direction[free] = vectors[:, 0] * np.sign(vectors[int(np.argmax(np.abs(vectors[:, 0]))), 0])
        direction *= self.of.travel / float(np.abs(self.of.travel * direction).max())
        lower, upper = self.bounds(here.q)
        for halved in range(_TRIALS):
            move = self.step / 2.0**halved * direction
            tried = [np.clip(here.q + way * move, lower, upper) for way in (1.0, -1.0)]
            first, second = (Here(q, self.of.missing(q, self.goal)) for q in tried)
            best = second if second.size < first.size - _STANDS * here.size else first  # of equal ways always the same
            if best.size < here.size:
                return best, True
        return None, True

    def curvature(self, here: Here, J: Array) -> Array:
        """(n, n) second derivatives of |e|²/2 by y, but for squares of the angle that is missing."""
        bent = np.tensordot(here.missing, self.of.hessian(here.q), 1)
        return np.asarray(J.T @ J - (bent + bent.T) / 2.0)
