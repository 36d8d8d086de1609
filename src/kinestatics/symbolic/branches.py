"""Where several trigonometric polynomials vanish together, as a union of branches. Floor 7.

A branch is a list of equations; the common zeros are exactly the union of the branches. Conditions are split by their
factors; a factor of one joint is solved and put into the others, which then factor further.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..progress import Job
from .halfangle import HalfAngleRing
from .ring import Polynomial

Condition = tuple[Polynomial, ...]
"""Irreducible factors, one of which must vanish."""


@dataclass(frozen=True, eq=False)
class Branch:
    """One part of a zero set.

    Attributes:
        equations: polynomials that vanish on it, each irreducible.
        others: conditions that hold besides and were not split for want of time: a factor of each vanishes.
    """

    equations: tuple[Polynomial, ...]
    others: tuple[Condition, ...] = ()


@dataclass
class Splitter:
    """Splits conditions into branches.

    Attributes:
        half: ring of the polynomials.
        job: when its time is up, what is left is handed back unsolved.
        void: tells of a factor that it certainly has no zeros.
    """

    half: HalfAngleRing
    job: Job
    void: Callable[[Polynomial], bool]
    steps: int = 0
    _factors: dict[str, Condition | None] = field(default_factory=dict)
    _seen: set[frozenset[str]] = field(default_factory=set)

    def split(self, polynomials: Iterable[Polynomial]) -> list[Branch]:
        """The branches of the common zeros."""
        conditions = [c for p in polynomials if (c := self.condition(p)) is not None]
        return _without_contained(list(self._branches(conditions, ())))

    def condition(self, p: Polynomial) -> Condition | None:
        """Distinct factors of a polynomial that depend on the joints and may vanish; None for zero, () where none may."""
        if p == 0:
            return None
        key = str(p)
        if key not in self._factors:
            factors = (factor for factor, _ in self.half.factored(p)[1])
            self._factors[key] = tuple(factor for factor in factors if not self.void(factor))
        return self._factors[key]

    def _branches(self, conditions: list[Condition], branch: tuple[Polynomial, ...]) -> Iterable[Branch]:
        """Branches on which `branch` vanishes and every condition holds."""
        self.steps += 1
        if any(not condition for condition in conditions):
            return
        conditions = _necessary(conditions)
        state = frozenset((*map(str, branch), *(str(sorted(map(str, c))) for c in conditions)))
        if state in self._seen:
            return
        self._seen.add(state)
        if not conditions:
            yield Branch(branch)
            return
        self.job.tell("splitting conditions")
        if self.job.late:
            yield Branch(branch, tuple(conditions))
            return
        conditions.sort(key=self._effort)
        for factor in conditions[0]:
            rest = [c for c in conditions[1:] if factor not in c]
            yield from self._with(factor, rest, branch)

    def _with(self, factor: Polynomial, rest: list[Condition], branch: tuple[Polynomial, ...]) -> Iterable[Branch]:
        """Branches on which one factor more vanishes. A factor of one joint is solved, and put into all others."""
        joints = self.half.joints_of(factor)
        put = self._solution(factor, joints[0]) if len(joints) == 1 else None
        if put is None:
            reduced = rest if len(joints) > 1 else self._reduced(factor, joints[0], rest)
            yield from self._branches(reduced, (*branch, factor))
            return
        kept, conditions = [factor], []
        for p in branch:
            if joints[0] not in self.half.joints_of(p):
                kept.append(p)
            elif (new := self.condition(self._put(p, put))) is not None:
                conditions.append(new)
        for condition in rest:
            if (new := self._condition_with(condition, put)) is not None:
                conditions.append(new)
        yield from self._branches(conditions, tuple(kept))

    def _condition_with(self, condition: Condition, put: dict[int, Polynomial]) -> Condition | None:
        found: dict[str, Polynomial] = {}
        for p in condition:
            new = self.condition(self._put(p, put)) if any(p.degrees()[i] for i in put) else (p,)
            if new is None:
                return None
            found |= {str(factor): factor for factor in new}
        return tuple(found.values())

    def _solution(self, factor: Polynomial, joint: int) -> dict[int, Polynomial] | None:
        """Where a factor of one joint vanishes, as values for the joint's generators; None where it is no linear one."""
        powers, places = factor.degrees(), self._places(joint)
        zero, one = self.half.context.constant(0), self.half.context.constant(1)
        if len(places) == 1:  # a sliding joint
            return {places[0]: zero} if len(factor.to_dict()) == 1 else None
        t, u = places
        if max(powers[t], powers[u]) > 1:
            return None
        return {t: -self._put(factor, {t: zero, u: one}), u: self._put(factor, {t: one, u: zero})}

    def _reduced(self, factor: Polynomial, joint: int, rest: list[Condition]) -> list[Condition]:
        """The conditions with remainders by a quadratic factor of one joint in place of their own factors."""
        places = self._places(joint)
        if len(places) == 1 or max(factor.degrees()[i] for i in places) != 2:
            return rest
        found = []
        for condition in rest:
            factors: dict[str, Polynomial] = {}
            for p in condition:
                new = self.condition(self._remainder(p, factor, *places)) if joint in self.half.joints_of(p) else (p,)
                if new is None:
                    break
                factors |= {str(x): x for x in new}
            else:
                found.append(tuple(factors.values()))
        return found

    def _remainder(self, p: Polynomial, factor: Polynomial, t: int, u: int) -> Polynomial:
        """p modulo a t² + b t u + c u², up to factors that cannot vanish with it: linear in t and u."""
        pieces = _by_power(self.half, p, t, u)
        square = _by_power(self.half, factor, t, u)
        a, b, c = (square.get(k, self.half.context.constant(0)) for k in (2, 1, 0))
        degree = max(x + y for x, y in ((e[t], e[u]) for e in p.to_dict()))
        if degree < 2 or a == 0:
            return p
        top = [pieces.get(k, self.half.context.constant(0)) for k in range(degree + 1)]  # of t^k u^(degree - k)
        for k in range(degree, 1, -1):
            lead = top[k]
            top = [x * a for x in top[:k]]
            top[k - 1] -= lead * b
            top[k - 2] -= lead * c
        generators = self.half.context.gens()
        return top[1] * generators[t] + top[0] * generators[u]

    def _places(self, joint: int) -> list[int]:
        ring = self.half.ring
        if ring.turns[joint]:
            a = sum(ring.turns[:joint])
            return [2 * a, 2 * a + 1]
        return [2 * len(ring.angles) + list(ring.slides).index(joint)]

    def _put(self, p: Polynomial, values: dict[int, Polynomial]) -> Polynomial:
        generators = self.half.context.gens()
        return p.compose(*[values.get(i, g) for i, g in enumerate(generators)], ctx=self.half.context)

    def _effort(self, condition: Condition) -> tuple[int, int, int]:
        coupled = sum(len(self.half.joints_of(p)) > 1 for p in condition)
        return coupled, len(condition), sum(len(p.to_dict()) for p in condition)


def _by_power(half: HalfAngleRing, p: Polynomial, t: int, u: int) -> dict[int, Polynomial]:
    """Coefficients of the powers of one generator, the other one set to 1."""
    groups: dict[int, dict[Any, Any]] = {}
    for exponents, coefficient in p.to_dict().items():
        rest = tuple(0 if i in (t, u) else e for i, e in enumerate(exponents))
        groups.setdefault(exponents[t], {})[rest] = coefficient
    return {power: half.context.from_dict(terms) for power, terms in groups.items()}


def _necessary(conditions: list[Condition]) -> list[Condition]:
    """Without those that another one implies: its factors are among theirs."""
    kept: list[set[str]] = []
    found = []
    for condition in sorted(conditions, key=len):
        own = set(map(str, condition))
        if not any(other <= own for other in kept):
            kept.append(own)
            found.append(condition)
    return found


def _without_contained(branches: Sequence[Branch]) -> list[Branch]:
    """Without branches whose equations include those of another one."""
    kept: list[tuple[set[str], Branch]] = []
    for branch in sorted(branches, key=lambda b: (len(b.equations) + len(b.others), bool(b.others))):
        own = set(map(str, branch.equations)) | {str(c) for c in branch.others}
        if not any(other <= own for other, _ in kept):
            kept.append((own, branch))
    return [branch for _, branch in kept]
