"""Aspects on the torus and within joint limits: counts of a flood fill, joins that hold, slides, budgets, words."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.singular_sets import singularities
from kinestatics.singular_sets.components import spectrum
from kinestatics.singular_sets.landscape import Landscape
from kinestatics.symbolic.functions import WaveFunction

ndimage = pytest.importorskip("scipy.ndimage", reason="a judge of the dev extra")


def orthogonal(rows, lower, upper):
    """An arm of three joints with axes at right angles, and its limits."""
    arm = ks.from_dh([(*row, 0.0) for row in rows], convention="standard")
    return replace(arm, lower=np.array(lower, dtype=float), upper=np.array(upper, dtype=float))


def determinant(arm, q, task):
    return np.linalg.det(ks.jacobian(arm, q, check_finite=False).array[..., list(task.rows), :])


def flood(*factors):
    """Regions of a grid in a box in which every factor has one sign: apart, since a grid leaks where zeros of two cross."""
    found = 0
    for signs in itertools.product((1, -1), repeat=len(factors)):
        inside = np.all([side * values > 0 for side, values in zip(signs, factors, strict=True)], axis=0)
        labels, _ = ndimage.label(inside)
        found += int(labels.max())
    return found


def product(equation, q):
    """The parts of an equation multiplied: it changes sign where one of them does."""
    return np.prod([f.value(q) for f in equation.functions], axis=0)


def grid(lower, upper, sizes):
    axes = [low + (np.arange(k) + 0.5) * (high - low) / k for low, high, k in zip(lower, upper, sizes, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1)


ROWS = (
    ((0.59, -np.pi / 2, 0.0), (0.79, np.pi / 2, 0.37), (0.72, 0.0, 0.0)),
    ((0.24, -np.pi / 2, 0.0), (0.9, np.pi / 2, 0.63), (1.22, 0.0, 0.0)),
    ((1.0, -np.pi / 2, 0.0), (2.0, np.pi / 2, 1.0), (1.5, 0.0, 0.0)),
)
LIMITS = (
    ([-1, -2.0, -1.5], [1, 2.5, 2.8]),
    ([-1, -4.0, -5.5], [1, 6.0, 3.9]),  # more than a turn: the same places in different regions
    ([-1, 0.3, -0.6], [1, 1.4, 7.2]),
)


@pytest.mark.parametrize(("arm", "box"), [(0, 0), (0, 1), (1, 1), (1, 2), (2, 0)])
def test_aspects_within_limits_are_those_of_a_flood_fill(arm, box):
    """Two joints in their box, in the covering space and not on the torus."""
    arm = orthogonal(ROWS[arm], *LIMITS[box])
    found = singularities(arm, "position")
    q = np.zeros((500, 500, 3))
    q[..., 1:] = grid(arm.lower[1:], arm.upper[1:], (500, 500))
    count = flood(*(product(equation, q) for equation, _ in found.factors if equation.real is not False))
    aspects = found.aspects(150, limits=True)
    assert aspects.count == count
    assert aspects.settled
    assert not aspects.proved


def test_a_neck_that_a_coarse_grid_does_not_see():
    """Six regions on a grid of 500², as of one of 2000²; one of 4000² finds the necks, and so do passes."""
    arm = orthogonal(ROWS[2], *LIMITS[1])
    found = singularities(arm, "position")
    q = np.zeros((500, 500, 3))
    q[..., 1:] = grid(arm.lower[1:], arm.upper[1:], (500, 500))
    assert flood(determinant(arm, q.reshape(-1, 3), found.task).reshape(500, 500)) == 6
    assert found.aspects(150, limits=True).count == 4


@pytest.mark.parametrize("name", ["puma_560", "irb_140"])
def test_aspects_of_arms_whose_wrist_is_a_factor(name):
    """Regions of (q2, q3) by flood fill, times the two signs of q5; one of the IRB 140's is 0.005 rad small."""
    arm = ks.load(name)
    found = singularities(arm)
    q = np.zeros((1200, 1200, 6))
    q[..., 1:3] = grid(arm.lower[1:3], arm.upper[1:3], (1200, 1200))
    regions = flood(*(product(equation, q) for equation, _ in found.factors if 4 not in equation.columns))
    assert -np.pi < arm.lower[4] < 0 < arm.upper[4] < np.pi
    assert found.aspects(200, limits=True).count == 2 * regions


def test_two_turns_of_a_ur5e_give_32():
    """q3 and q5 pass four half turns each; in each of the halves of q3 the shoulder has one region of each sign."""
    arm = ks.load("ur5e")
    found = singularities(arm)
    aspects = found.aspects(40, limits=True)
    x = -2 * np.pi + (np.arange(96) + 0.5) * 4 * np.pi / 96
    q2, q3, q4 = np.meshgrid(x, np.pi * (np.arange(24) + 0.5) / 24, x, indexing="ij")
    q = np.zeros((*q2.shape, 6))
    q[..., 1], q[..., 2], q[..., 3], q[..., 4] = q2, q3, q4, 1.0
    shoulder = flood(determinant(arm, q.reshape(-1, 6), found.task).reshape(q2.shape))
    assert shoulder == 2
    assert aspects.count == 4 * 4 * shoulder == 32
    assert found.aspects(300).count == 8


def test_representatives_are_regular_and_within_limits():
    """Each has the sign it is said to have; halves of a two-turn joint have representatives of their own."""
    arm = ks.load("puma_560")
    found = singularities(arm)
    aspects = found.aspects(300, limits=True)
    q = aspects.representatives
    assert np.all((q >= arm.lower) & (q <= arm.upper))
    signs = np.sign(determinant(arm, q, found.task))
    np.testing.assert_array_equal(signs * signs[0], aspects.signs * aspects.signs[0])
    assert spectrum(arm, q, found.task, "tip")[:, -1].min() > 1e-4
    assert len(np.unique(np.round(q, 3), axis=0)) == aspects.count


def test_slides_within_limits_and_without():
    """q3² of the Stanford arm: with q3 > 0 the wrist and the shoulder count; without limits there is no count."""
    arm = ks.load("stanford_arm")
    found = singularities(arm)
    aspects = found.aspects(limits=True)
    assert aspects.proved
    inside = [np.arange(-3, 4) * np.pi for _ in range(2)]
    shoulder, wrist = (
        1 + int(((zeros > arm.lower[j]) & (zeros < arm.upper[j])).sum()) for zeros, j in zip(inside, (1, 4), strict=True)
    )
    slide = 2 if arm.lower[2] < -1e-3 and arm.upper[2] > 1e-3 else 1
    assert aspects.count == shoulder * wrist * slide
    with pytest.raises(ks.ConfigurationError, match=r"KS398.*slides"):
        found.aspects()


def test_a_slide_in_a_factor_of_several_joints():
    """A bent arm R-R-P whose shoulder factor has the slide in it: the regions of a flood fill over (q2, q3)."""
    arm = ks.from_dh(
        [(0.3, -np.pi / 2, 0.0, 0.0), (0.2, np.pi / 2, 0.1, 0.0), (0.0, 0.0, 0.0, 0.0)],
        convention="standard",
        types="RRP",
    )
    arm = replace(arm, lower=np.array([-1.0, -2.5, -0.8]), upper=np.array([1.0, 2.9, 0.9]))
    found = singularities(arm, "position")
    q = np.zeros((400, 400, 3))
    q[..., 1:] = grid(arm.lower[1:], arm.upper[1:], (400, 400))
    count = flood(*(product(equation, q) for equation, _ in found.factors if equation.real is not False))
    assert count > 1
    assert found.aspects(150, limits=True).count == count


def test_a_way_that_keeps_its_sign_does():
    """Of random straight pieces, none that is taken crosses zero on a fine sampling; most that do not cross are taken."""
    found = singularities(orthogonal(ROWS[1], *LIMITS[0]), "position")
    f = WaveFunction.of(found.space.half, found.polynomial, found.space.values)
    land = Landscape(f, (1, 2), np.full(2, -np.inf), np.full(2, np.inf))
    rng = np.random.default_rng(0)
    a, v = rng.uniform(-3, 3, (2000, 2)), rng.normal(size=(2000, 2))
    kept = land.keeps_sign(a, v)
    s = np.linspace(0, 1, 401)[:, None, None]
    one_sign = np.ptp(np.sign(land.f.value(a + s * v)), axis=0) == 0
    assert not np.any(kept & ~one_sign)
    assert kept.sum() > 0.95 * one_sign.sum() > 100
    tops = land.climbed(a)
    assert np.all(np.sign(land.f.value(tops)) == np.sign(land.f.value(a)))
    assert np.all(np.abs(land.f.value(tops)) >= np.abs(land.f.value(a)))


def test_the_bound_along_a_way_holds_with_slides():
    """b(v) bounds the second derivative along v in the box, by finite differences."""
    arm = ks.from_dh([(0.3, -1.2, 0.0, 0.0), (0.2, 1.1, 0.1, 0.0), (0, 0, 0, 0)], convention="standard", types="RRP")
    found = singularities(arm, "position")
    f = WaveFunction.of(found.space.half, found.polynomial, found.space.values)
    land = Landscape(f, (1, 2), np.array([-np.inf, -0.7]), np.array([np.inf, 0.9]))
    rng = np.random.default_rng(1)
    x, v = rng.uniform([-3, -0.69], [3, 0.89], (500, 2)), rng.normal(size=(500, 2))
    second = np.einsum("ki,kij,kj->k", v, land.f.hessian(x), v)
    assert np.all(np.abs(second) <= land.bend(v) * (1 + 1e-12))


def test_time_words_and_data():
    """A job that is cut short says so; progress is told; what is proved is said to be."""
    found = singularities(ks.load("ur5e"))
    told = []
    cut = found.aspects(limits=True, budget=1e-3, progress=lambda what, share: told.append((what, share)))
    assert told
    assert not cut.settled
    assert "the time was up" in str(cut)
    aspects = singularities(ks.load("planar_2r")).aspects()
    assert str(aspects) == "2 aspects (proved: between zeros of single joints)"
    assert aspects.to_dict()["count"] == 2
    for bad in (0, -1.0, True):
        with pytest.raises(ks.ConfigurationError, match="KS353"):
            found.aspects(budget=bad)


def test_numbers_do_not_hang_on_lengths():
    """Elbow arms of random lengths: with an offset wrist centre there are 4 regions of (q2, q3), times 2 of the wrist."""
    rng = np.random.default_rng(5)
    half = np.pi / 2
    for a2, a3, d4 in rng.uniform(0.2, 0.8, (2, 3)):
        rows = [(0, -half, 0.0, 0), (a2, 0, 0.15, 0), (a3, -half, 0, 0), (0, half, d4, 0), (0, -half, 0, 0), (0, 0, 0.1, 0)]
        found = singularities(ks.from_dh(rows, convention="standard"))
        assert found.aspects(200).count == 8
