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

_MANY = 400
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
        import sympy

        ring, n = half.ring, len(half.ring.joints)
        m, turning = len(ring.angles), [j for j, turns in enumerate(ring.turns) if turns]
        constants = [float(x.subs(values)) for x in ring.constants]
        numbers = [float(values[x]) for x in ring.parameters] + [float(sympy.sqrt(p)) for p in ring.roots]
        first = 2 * m + len(ring.slides)
        if len(F) > _MANY:  # numbers first: fewer terms to go through
            F, numbers = _at_numbers(F, first, numbers), [1.0] * len(numbers)
        exponents, coefficients = _terms(F)
        size = coefficients * np.prod(np.array(numbers) ** exponents[:, first:], axis=1)
        degrees = half.degrees(F)
        found: dict[tuple[int, ...], Array] = {}
        for powers in {tuple(row) for row in exponents[:, 2 * m : first].tolist()}:
            chosen = np.all(exponents[:, 2 * m : first] == powers, axis=1)
            found[powers] = _spectrum(exponents[chosen, : 2 * m], size[chosen], degrees)
        frequencies, monomials, amplitudes = [], [], []
        for powers, tensor in found.items():
            for index in np.argwhere(tensor != 0):
                k = 2 * index - np.array(degrees) if m else index
                frequency, monomial = np.zeros(n), np.zeros(n, dtype=int)
                frequency[turning] = k[: len(turning)] / 2.0
                monomial[list(ring.slides)] = powers
                shift = float(np.dot(k[len(turning) :] / 2.0, constants)) if constants else 0.0
                frequencies.append(frequency)
                monomials.append(monomial)
                amplitudes.append(tensor[tuple(index)] * np.exp(1j * shift))
        return _gathered(np.array(frequencies).reshape(-1, n), np.array(monomials).reshape(-1, n), np.array(amplitudes))

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


def _at_numbers(F: Polynomial, first: int, numbers: list[float]) -> Polynomial:
    """The polynomial with numbers for its last generators, exactly those of the floats."""
    context = F.context()
    values = list(context.gens())
    for k, x in enumerate(numbers):
        values[first + k] = context.constant(flint().fmpq(*x.as_integer_ratio()))
    return F.compose(*values, ctx=context)


def _terms(F: Polynomial) -> tuple[Array, Array]:
    """Exponents (k, generators) and coefficients (k)."""
    terms = F.to_dict()
    exponents = np.array([[int(e) for e in key] for key in terms], dtype=int).reshape(len(terms), -1)
    return exponents, np.array([int(c.p) / int(c.q) for c in terms.values()])


def _spectrum(exponents: Array, coefficients: Array, degrees: tuple[int, ...]) -> Array:
    """Coefficients of e^(i k x / 2), k = -degree, -degree + 2, ..., along an axis for each angle."""
    if not degrees:  # joints that slide, and no angle
        return np.array(coefficients.sum(), dtype=complex)
    tensor = np.zeros([d + 1 for d in degrees], dtype=complex)
    np.add.at(tensor, tuple(exponents[:, 2 * a] for a in range(len(degrees))), coefficients)
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
    keys = np.concatenate([frequencies * sign[:, None], powers], axis=1)
    unique, place = np.unique(keys, axis=0, return_inverse=True)
    cosines, sines = np.zeros(len(unique)), np.zeros(len(unique))
    np.add.at(cosines, place.ravel(), amplitudes.real)
    np.add.at(sines, place.ravel(), -sign * amplitudes.imag)
    size = np.hypot(cosines, sines)
    kept = size > _NOTHING * size.max(initial=0.0)
    if not kept.any():
        return WaveFunction(np.zeros((1, n)), np.zeros((1, n), dtype=int), np.zeros(1), np.zeros(1))
    return WaveFunction(unique[kept, :n], unique[kept, n:].astype(int), cosines[kept], sines[kept])
