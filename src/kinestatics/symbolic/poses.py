"""Poses and vectors of exact polynomials. Floor 7."""

from __future__ import annotations

from typing import Any, NamedTuple

from .ring import Matrix, Polynomial, TrigonometricRing

Vector = list[Polynomial]


class Pose(NamedTuple):
    """A rotation (3, 3) and a point (3) of polynomials."""

    R: Matrix
    p: Vector


def identity(ring: TrigonometricRing) -> Pose:
    """The pose that moves nothing."""
    return Pose([[ring.one if i == j else ring.zero for j in range(3)] for i in range(3)], [ring.zero] * 3)


def read_pose(ring: TrigonometricRing, T: Any) -> Pose:
    """(4, 4) SymPy expressions as polynomials."""
    entries = [[ring.read(x) for x in row] for row in T[:-1]]
    return Pose([row[:-1] for row in entries], [row[-1] for row in entries])


def product(ring: TrigonometricRing, A: Matrix, B: Matrix) -> Matrix:
    """A B."""
    return [[ring.total(x * row[j] for x, row in zip(line, B, strict=True)) for j in range(3)] for line in A]


def turned(ring: TrigonometricRing, R: Matrix, v: Vector) -> Vector:
    """R v."""
    return [ring.total(a * b for a, b in zip(row, v, strict=True)) for row in R]


def crossed(ring: TrigonometricRing, a: Vector, b: Vector) -> Vector:
    """a × b."""
    return [ring.reduced(a[i - 2] * b[i - 1] - a[i - 1] * b[i - 2]) for i in range(3)]


def transposed(R: Matrix) -> Matrix:
    """Rᵀ."""
    return [list(column) for column in zip(*R, strict=True)]


def compose(ring: TrigonometricRing, A: Pose, B: Pose) -> Pose:
    """A B."""
    return Pose(product(ring, A.R, B.R), [ring.reduced(a + b) for a, b in zip(A.p, turned(ring, A.R, B.p), strict=True)])


def inverse(ring: TrigonometricRing, A: Pose) -> Pose:
    """A⁻¹."""
    R = transposed(A.R)
    return Pose(R, [-x for x in turned(ring, R, A.p)])


def determinant(ring: TrigonometricRing, M: Matrix) -> Polynomial:
    """The determinant, by expansion along the emptiest row or column, in canonical form at every step."""
    n = len(M)
    if n == 0:
        return ring.one
    if n == 1:
        return M[0][0]
    if n == 2:
        return ring.reduced(M[0][0] * M[1][1] - M[0][1] * M[1][0])
    filled = [(sum(x != 0 for x in row), False, i) for i, row in enumerate(M)]
    filled += [(sum(row[j] != 0 for row in M), True, j) for j in range(n)]
    _, by_column, k = min(filled)
    parts = []
    for i in range(n):
        r, c = (i, k) if by_column else (k, i)
        if M[r][c] == 0:
            continue
        minor = [[row[j] for j in range(n) if j != c] for a, row in enumerate(M) if a != r]
        term = M[r][c] * determinant(ring, minor)
        parts.append(term if (r + c) % 2 == 0 else -term)
    return ring.total(parts)
