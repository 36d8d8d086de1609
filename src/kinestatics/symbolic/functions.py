"""A factor as a function of numbers: Σ (a cos φ + b sin φ) Π q^e with exact derivatives and bounds on them. Floor 7."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..namespaces import Array
from .halfangle import HalfAngleRing
from .ring import Polynomial, flint

_NOTHING = 1e-15
"""Waves this small beside the largest are the rounding of floats."""


@dataclass(frozen=True, eq=False)
class WaveFunction:
    """f(q) = Σ_k (cosines_k cos φ_k + sines_k sin φ_k) Π_j q_j^powers_kj, with φ_k = frequencies_k · q.

    Attributes:
        frequencies: (m, n) multiples of one half; powers: (m, n) whole, zero for joints that turn.
        cosines, sines: (m).
    """

    frequencies: Array
    powers: Array
    cosines: Array
    sines: Array

    @classmethod
    def of(cls, half: HalfAngleRing, F: Polynomial, values: Mapping[Any, float]) -> WaveFunction:
        """The function of a polynomial in half angles.

        Args:
            half: its ring.
            values: numbers for its symbols.
        """
        ring, n = half.ring, len(half.ring.joints)
        turning, first = [j for j, turns in enumerate(ring.turns) if turns], 2 * len(ring.angles)
        if (whole := half.origin(F)) is not None:  # far fewer terms, of which fewer yet are left with numbers in
            F = half.lifted(_at_numbers(whole, half, values))
        degrees = half.degrees(F)[: len(turning)]
        found: dict[tuple[int, ...], Array] = {}
        for powers, exponents, size in _by_slides(F, first, len(ring.slides), _numbers_of(half, values)):
            found[powers] = _spectrum(exponents[:, : 2 * len(turning)], size, degrees)
        frequencies, monomials, amplitudes = [], [], []
        for powers, tensor in found.items():
            places = np.argwhere(tensor != 0)
            frequency, monomial = np.zeros((len(places), n)), np.zeros((len(places), n), dtype=int)
            if turning:
                frequency[:, turning] = places - np.array(degrees) / 2.0
            monomial[:, list(ring.slides)] = powers
            frequencies.append(frequency)
            monomials.append(monomial)
            amplitudes.append(tensor[tensor != 0])
        return _gathered(np.concatenate(frequencies), np.concatenate(monomials), np.concatenate(amplitudes))

    @cached_property
    def joints(self) -> tuple[int, ...]:
        """The joints it depends on."""
        return tuple(int(j) for j in np.flatnonzero(np.any((self.frequencies != 0) | (self.powers != 0), axis=0)))

    @cached_property
    def slides(self) -> bool:
        """Whether a joint enters as it is, and not as an angle."""
        return bool(np.any(self.powers))

    @cached_property
    def scale(self) -> float:
        """Σ of the amplitudes: a bound on |f| where no joint slides (else where slides are within 1 m)."""
        return float(np.hypot(self.cosines, self.sines).sum())

    def _parts(self, q: Array) -> tuple[Array, Array, Array]:
        """(..., m): the waves, their derivatives by φ, and the monomials."""
        phase = q @ self.frequencies.T
        c, s = np.cos(phase), np.sin(phase)
        monomial = np.prod(q[..., None, :] ** self.powers, axis=-1) if self.slides else np.ones(phase.shape)
        return self.cosines * c + self.sines * s, self.sines * c - self.cosines * s, monomial

    def value(self, q: Array) -> Array:
        """(...) for q (..., n) [rad or m]."""
        wave, _, monomial = self._parts(np.asarray(q, dtype=float))
        return (wave * monomial).sum(-1)

    def gradient(self, q: Array) -> Array:
        """(..., n)."""
        q = np.asarray(q, dtype=float)
        wave, slope, monomial = self._parts(q)
        found = (slope * monomial) @ self.frequencies
        for j in range(q.shape[-1]) if self.slides else ():
            found[..., j] += (wave * self._lowered(q, (j,))).sum(-1)
        return found

    def hessian(self, q: Array) -> Array:
        """(..., n, n)."""
        q = np.asarray(q, dtype=float)
        wave, slope, monomial = self._parts(q)
        K = self.frequencies
        found = -np.einsum("...m,mi,mj->...ij", wave * monomial, K, K)
        for j in range(q.shape[-1]) if self.slides else ():
            lowered = self._lowered(q, (j,))
            mixed = (slope * lowered) @ K
            found[..., j, :] += mixed
            found[..., :, j] += mixed
            for i in range(q.shape[-1]):
                found[..., i, j] += (wave * self._lowered(q, (j, i))).sum(-1)
        return found

    def _lowered(self, q: Array, by: tuple[int, ...]) -> Array:
        """The monomials differentiated by some sliding joints."""
        powers, factor = self.powers.copy(), np.ones(len(self.powers))
        for j in by:
            factor = factor * powers[:, j]
            powers[:, j] = np.maximum(powers[:, j] - 1, 0)
        return factor * np.prod(q[..., None, :] ** powers, axis=-1)

    @cached_property
    def hessian_bound(self) -> Array:
        """(n, n) entries that no |∂²f/∂q_i ∂q_j| exceeds, where no joint slides."""
        size, K = np.hypot(self.cosines, self.sines), np.abs(self.frequencies)
        return np.einsum("m,mi,mj->ij", size, K, K)


def _at_numbers(p: Polynomial, half: HalfAngleRing, values: Mapping[Any, float]) -> Polynomial:
    """A polynomial in whole angles with numbers for all that is no joint, exactly those of the floats."""
    ring, numbers = half.ring, _numbers_of(half, values)
    context, generators = p.context(), list(p.context().gens())
    for a, x in enumerate(ring.constants, start=sum(ring.turns)):
        angle = float(x.subs(values))
        generators[ring.angles[a].cosine] = _fraction(context, np.cos(angle))
        generators[ring.angles[a].sine] = _fraction(context, np.sin(angle))
    first = len(ring.parameters) + len(ring.roots)
    for k, x in enumerate(numbers[len(numbers) - first :]):
        generators[ring.parameter_place(k)] = _fraction(context, x)
    return p.compose(*generators, ctx=context)


def _fraction(context: Any, x: Any) -> Polynomial:
    return context.constant(flint().fmpq(*float(x).as_integer_ratio()))


def _numbers_of(half: HalfAngleRing, values: Mapping[Any, float]) -> Array:
    """(g) numbers for the generators that are no joints, 1 for those that are."""
    ring = half.ring
    found = np.ones(len(half.context.names()), dtype=np.longdouble)
    for a, x in enumerate(ring.constants, start=sum(ring.turns)):
        angle = np.longdouble(float(x.subs(values))) / 2
        found[2 * a], found[2 * a + 1] = np.sin(angle), np.cos(angle)
    first = 2 * len(ring.angles) + len(ring.slides)
    numbers = [values[x] for x in ring.parameters] + [np.sqrt(np.longdouble(p)) for p in ring.roots]
    found[first : first + len(numbers)] = numbers
    return found


def _by_slides(F: Polynomial, first: int, slides: int, numbers: Array) -> list[tuple[tuple[int, ...], Array, Array]]:
    """Terms by powers of the joints that slide: these, exponents (k, generators) and coefficients (k) with numbers in."""
    exponents = np.array([[int(e) for e in key] for key in F.monoms()], dtype=int).reshape(len(F), -1)
    size = np.array([int(c.p) / int(c.q) for c in F.coeffs()], dtype=np.longdouble)
    for place in np.flatnonzero(numbers != 1):
        size = size * numbers[place] ** exponents[:, place]
    powers = exponents[:, first : first + slides]
    found = []
    for own in sorted({tuple(row) for row in powers.tolist()}) or [()]:
        chosen = np.all(powers == own, axis=1)
        found.append((own, exponents[chosen], size[chosen]))
    return found


def _spectrum(exponents: Array, coefficients: Array, degrees: tuple[int, ...]) -> Array:
    """Coefficients of e^(i k x / 2), k = -degree, -degree + 2, ..., along an axis for each angle."""
    if not degrees:  # joints that slide, and no angle
        return np.array(coefficients.sum(), dtype=complex)
    shape = [d + 1 for d in degrees]
    sums = np.zeros(shape, dtype=np.longdouble)
    np.add.at(sums, tuple(exponents[:, 2 * a] for a in range(len(degrees))), coefficients)
    tensor = sums.astype(complex)
    for a, degree in enumerate(degrees):
        if degree:
            tensor = np.moveaxis(np.tensordot(_waves_of_powers(degree), tensor, (1, a)), 0, a)
    return tensor


def _waves_of_powers(degree: int) -> Array:
    """(degree + 1, degree + 1): column t holds sin(x/2)^t cos(x/2)^(degree - t) by its waves."""
    found = np.zeros((degree + 1, degree + 1), dtype=complex)
    for t in range(degree + 1):
        wave = np.ones(1, dtype=complex)
        for _ in range(t):
            wave = np.convolve(wave, [0.5j, 0.0, -0.5j])
        for _ in range(degree - t):
            wave = np.convolve(wave, [0.5, 0.0, 0.5])
        found[:, t] = wave[::2] if degree else wave
    return found


def _gathered(frequencies: Array, powers: Array, amplitudes: Array) -> WaveFunction:
    """Equal waves added, a wave and its mirror image as one, those of rounding left out."""
    n = frequencies.shape[1]
    lead = np.array([next((x for x in row if x), 0.0) for row in frequencies])
    sign = np.where(lead < 0, -1.0, 1.0)
    keys = np.concatenate([frequencies * sign[:, None] + 0.0, powers], axis=1)  # no -0
    unique, place = np.unique(keys, axis=0, return_inverse=True)
    cosines, sines = np.zeros(len(unique)), np.zeros(len(unique))
    np.add.at(cosines, place.ravel(), amplitudes.real)
    np.add.at(sines, place.ravel(), -sign * amplitudes.imag)
    size = np.hypot(cosines, sines)
    kept = size > _NOTHING * size.max(initial=0.0)
    if not kept.any():
        return WaveFunction(np.zeros((1, n)), np.zeros((1, n), dtype=int), np.zeros(1), np.zeros(1))
    return WaveFunction(unique[kept, :n], unique[kept, n:].astype(int), cosines[kept], sines[kept])
