"""Bounds of many factors on many pieces at once, in floats whose rounding is accounted for.

Only what IEEE 754 says of +, - and * is used, and sums in any order, fused or not. With u = 2^-53:

- sin(q_j/2) and cos(q_j/2) at the floats q_j of a piece's centre are intervals of Arb of radius below 2^-50; their middles,
  as one complex number, are off by less than 2^-48.
- A product of complex numbers is off by less than 4u of its size, so that e^(iφ_m), a product of N of these numbers and
  their powers (N = Σ_j |frequencies_mj|, below 2^20), is off by less than N (2^-48 + 5u)(1 + 2^-20) < N 2^-47.
- The amplitudes A - iB come from Arb and are off by ρ, a bound that Arb gives.
- A sum of products of L + 1 numbers over M terms is off by less than (M + L) u (1 + 2^-20) of the sum of their sizes,
  for which (M + L) 2^-52 is taken.

What is left out are sums and products of these bounds themselves: all their terms are positive, so that they are right to
2^-35 of their size as long as fewer than 2^17 numbers are added; `_MORE` is far above that. `_TINY` covers
underflow, `_SQUARED` that of squares.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..namespaces import Array
from ..symbolic.ring import flint
from .enclosure import PRECISION, Domain, Terms

_CIRCLE, _UNIT, _RADIUS = 2.0**-47, 2.0**-52, 2.0**-50
_MORE, _TINY, _SQUARED = 1.0 + 2.0**-30, 1e-280, 1e-150
_MOST = 2**16  # terms or half turns of a wave that the argument above covers, with room


@dataclass(frozen=True, eq=False)
class Bounds:
    """What is known of f factors on p pieces.

    Attributes:
        values: (p, f) about f(centre); slopes: (p, k, f) about ∂f/∂s_i there; half: (p, k) half widths of the pieces.
        radius: (p, f) |f - values| is nowhere larger on the piece; rounding: (p, f) the part of it that halving keeps.
        bends: (p, k, f) what each parameter adds to the radius by its second derivatives.
    """

    values: Array
    slopes: Array
    half: Array
    radius: Array
    rounding: Array
    bends: Array

    @property
    def known(self) -> Array:
        """(p, f) whether the factor has one sign all over the piece, proved."""
        return np.abs(self.values) > self.radius * _MORE + _TINY

    @property
    def share(self) -> Array:
        """(p, f) |value| over radius: above 1 the sign is known, as good as."""
        return np.abs(self.values) / (self.radius + _TINY)


@dataclass(frozen=True, eq=False)
class FactorTable:
    """f factors by the waves that they share: f_k(q) = Σ_m (cosines_mk cos φ_m + sines_mk sin φ_m) Π_j q_j^powers_mj.

    Attributes:
        frequencies, powers: (m, n) whole numbers; of half angles, and of joints that slide.
        cosines, sines: (m, f) amplitudes; errors: (m, f) how far they may be off together.
    """

    frequencies: Array
    powers: Array
    cosines: Array
    sines: Array
    errors: Array

    @classmethod
    def of(cls, factors: Sequence[Terms], n: int) -> FactorTable:
        """The table of some factors in n joints."""
        rows: dict[tuple[int, ...], int] = {}
        entries: list[tuple[int, int, float, float, float]] = []
        for column, terms in enumerate(factors):
            keys = np.concatenate([terms.frequencies, terms.powers], axis=1).tolist()
            for key, A, B in zip(keys, terms.cosines, terms.sines, strict=True):
                row = rows.setdefault(tuple(key), len(rows))
                with flint().ctx.workprec(PRECISION):
                    entries.append((row, column, *_in_floats(A, B)))
        amplitudes = np.zeros((3, len(rows), len(factors)))
        for row, column, *three in entries:
            amplitudes[:, row, column] = three
        table = np.array(list(rows), dtype=int).reshape(len(rows), 2 * n)
        return cls(table[:, :n], table[:, n:], *amplitudes)

    @property
    def waves(self) -> int:
        """How many there are, at least 1."""
        return max(1, len(self.frequencies))

    @cached_property
    def sizes(self) -> Array:
        """(m, f) no amplitude is larger."""
        size = np.sqrt(self.cosines * self.cosines + self.sines * self.sines)  # a root is rounded right, unlike hypot
        there = (self.cosines != 0) | (self.sines != 0) | (self.errors != 0)
        return np.where(there, size * _MORE + self.errors + _SQUARED, 0.0)

    @cached_property
    def scales(self) -> Array:
        """(f) Σ of the amplitudes of each factor."""
        return self.sizes.sum(axis=0)

    @cached_property
    def _off(self) -> Array:
        """(m, f) how far a term's value may be off, in all: amplitude, wave, products and sum."""
        length, degrees, n = len(self.powers), self.powers.sum(axis=1), self.powers.shape[1]
        halves = np.abs(self.frequencies).sum(axis=1)
        if length > _MOST or max(halves.max(initial=0), degrees.max(initial=0)) > _MOST:
            return np.full(self.cosines.shape, np.inf)
        rounding = halves * _CIRCLE + (2 * length + degrees + 3 * n + 8) * _UNIT
        return (self.sizes * rounding[:, None] + self.errors) * _MORE

    @cached_property
    def _amplitudes(self) -> Array:
        return np.concatenate([self.cosines, self.sines])

    @cached_property
    def _turning(self) -> list[int]:
        return [int(j) for j in np.flatnonzero(self.frequencies.any(axis=0))]

    @cached_property
    def sliding(self) -> list[int]:
        """Joints that enter as they are."""
        return [int(j) for j in np.flatnonzero(self.powers.any(axis=0))]

    def restricted(self, columns: Sequence[int]) -> FactorTable:
        """The table of some of its factors."""
        chosen = list(columns)
        kept = (self.sizes[:, chosen] != 0).any(axis=1)
        parts = (self.cosines, self.sines, self.errors)
        return FactorTable(self.frequencies[kept], self.powers[kept], *(part[kept][:, chosen] for part in parts))

    def bounds(self, domain: Domain, low: Array, high: Array) -> Bounds:
        """All factors on the pieces low <= s <= high, each (p, k), of a domain.

        Law: |f(c + d) - f(c) - Σ_i t_i ∂f/∂s_i(c)| <= ½ max |f''|, along the straight line (Taylor, Lagrange's remainder).
        On a piece every phase moves by at most θ_m and every joint that slides by v_j, its size staying below y_j, so that
        a term of size a has |f''| <= a (θ² Y + 2 θ Y' + Y''), with Y = Π y_j^e and Y', Y'' its derivatives along v.
        """
        with np.errstate(all="ignore"):  # what overflows is infinite or no number, and decides nothing
            return self._bounds(domain, low, high)

    def _bounds(self, domain: Domain, low: Array, high: Array) -> Bounds:
        D, n = domain.directions, self.frequencies.shape[1]
        middle = (low + high) / 2.0
        half = np.nextafter(np.maximum(high - middle, middle - low), np.inf)
        q = domain.origin + middle @ D
        stray = (domain.slack + (np.abs(domain.origin) + np.abs(middle) @ np.abs(D)) * ((len(D) + 3) * _UNIT)) * _MORE
        waves = self._waves(q)
        halves = np.abs(self.frequencies.T) / 2.0
        rates, most = D @ (self.frequencies.T / 2.0), np.abs(D) @ halves
        above = np.abs(rates) + (n + 2) * _UNIT * most  # never below the rates themselves
        lost = stray @ halves
        theta = half @ above + lost
        slides = _Slides(self, q, D, half, stray) if len(self.sliding) else None
        real, imaginary = waves.real, waves.imag
        turned = rates * np.concatenate([-imaginary, real], axis=1).reshape(len(q), 2, 1, -1)
        first, second = theta * theta, half @ most + lost
        if slides is None:
            both = np.concatenate([real, imaginary], axis=1)
            bent, strayed, held = first, lost, 1.0 + second
            gradient = turned
        else:
            X, Y = slides.monomials, slides.sizes
            both = np.concatenate([real * X, imaginary * X], axis=1)
            bent = first * Y + 2.0 * theta * slides.first + slides.second
            strayed, held = lost * Y + slides.strayed, Y + second * Y + slides.first
            gradient = turned * X[:, None, None] + np.stack([real, imaginary], 1)[:, :, None] * slides.along[:, None]
        values = both @ self._amplitudes
        slopes = gradient.transpose(0, 2, 1, 3).reshape(len(q), len(D), 2 * len(self.powers)) @ self._amplitudes
        rounding = strayed @ self.sizes + held @ self._off
        bends = half[..., None] * (above * theta[:, None] if slides is None else slides.shares(above, theta))
        radius = np.einsum("pk,pkf->pf", half, np.abs(slopes)) + 0.5 * (bent @ self.sizes) + rounding
        return Bounds(values, slopes, half, radius, rounding, bends @ self.sizes)

    def _waves(self, q: Array) -> Array:
        """(p, m) e^(iφ) at the centres."""
        circle = _circle(q[:, self._turning])
        found = np.ones((len(q), len(self.frequencies)), dtype=complex)
        for column, j in enumerate(self._turning):
            k = self.frequencies[:, j]
            most = int(np.abs(k).max())
            powers = np.ones((len(q), 2 * most + 1), dtype=complex)
            for e in range(1, most + 1):
                powers[:, most + e] = powers[:, most + e - 1] * circle[:, column]
                powers[:, most - e] = powers[:, most + e].conj()
            found *= powers[:, most + k]
        return found

    def evaluated(self, q: Array) -> tuple[Array, Array]:
        """(p, f) values and (p, f, n) gradients in plain floats, for searches."""
        frequencies = self.frequencies / 2.0
        phase = q @ frequencies.T
        c, s = np.cos(phase), np.sin(phase)
        X = _lowered(q, self.powers, ())
        values = (c * X) @ self.cosines + (s * X) @ self.sines
        slope = (-s * X)[..., None, :] * frequencies.T @ self.cosines + (c * X)[..., None, :] * frequencies.T @ self.sines
        for j in self.sliding:
            lowered = _lowered(q, self.powers, (j,))
            slope[..., j, :] += (c * lowered) @ self.cosines + (s * lowered) @ self.sines
        return values, np.swapaxes(slope, -1, -2)


class _Slides:
    """What joints that slide contribute on pieces: the monomials of every term, and bounds of them and their derivatives."""

    def __init__(self, table: FactorTable, q: Array, D: Array, half: Array, stray: Array) -> None:
        joints, E = table.sliding, table.powers
        moved = half @ np.abs(D) + stray
        far = np.abs(q) + moved
        self.monomials, self.sizes = _lowered(q, E, ()), _lowered(far, E, ())
        lowered = {j: _lowered(q, E, (j,)) for j in joints}
        raised = {j: _lowered(far, E, (j,)) for j in joints}
        self.along = sum(D[:, j, None] * lowered[j][:, None] for j in joints)
        self.first = sum(moved[:, j, None] * raised[j] for j in joints)
        self.strayed = sum(stray[:, j, None] * raised[j] for j in joints)
        pairs = itertools.product(joints, joints)
        self.second = sum(moved[:, i, None] * moved[:, j, None] * _lowered(far, E, (i, j)) for i, j in pairs)
        self._reach = sum(np.abs(D[:, j, None]) * raised[j][:, None] for j in joints)

    def shares(self, above: Array, theta: Array) -> Array:
        """(p, k, m) about how much each parameter bends each term, by one half width."""
        return above * (theta * self.sizes + self.first)[:, None] + self._reach * (theta + self.second)[:, None]


def _lowered(q: Array, powers: Array, by: tuple[int, ...]) -> Array:
    """(p, m) Π q_j^e_j, differentiated by some joints; by products alone, as the power function promises nothing."""
    e, product = powers.copy(), np.ones((len(q), len(powers)))
    for j in by:
        product = product * e[:, j]
        e[:, j] = np.maximum(e[:, j] - 1, 0)
    for column in np.flatnonzero(e.any(axis=0)):
        for k in range(int(e[:, column].max())):
            product = product * np.where(e[:, column] > k, q[:, column, None], 1.0)
    return product


def _circle(q: Array) -> Array:
    """e^(i q/2) of floats, off by less than 2^-48; no number where that is not known."""
    arb = flint().arb
    places, index = np.unique(q, return_inverse=True)
    found = np.empty(len(places), dtype=complex)
    with flint().ctx.workprec(64):
        for k, x in enumerate(places.tolist()):
            s, c = (arb(x) / 2).sin_cos()
            close = float(s.rad()) < _RADIUS and float(c.rad()) < _RADIUS
            found[k] = complex(float(c), float(s)) if close else np.nan
    return found[index].reshape(q.shape)


def _in_floats(A: Any, B: Any) -> tuple[float, float, float]:
    """Two intervals as floats, and how far the pair of them may be from these."""
    arb = flint().arb
    a, b = float(A), float(B)
    off = float((A - arb(a)).abs_upper()) + float((B - arb(b)).abs_upper())
    return a, b, off * 1.0000001
