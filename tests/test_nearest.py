"""Distances inside the joint limits: their laws, an independent minimiser as a judge, and what is said where nothing is."""

import itertools
import json
import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.singular_sets import singularities
from kinestatics.singular_sets.components import spectrum

NAMES = ["ur5e, half", "panda", "iiwa_14", "irb_140", "planar_3r, limits"]


def limited(model, lower, upper):
    return replace(model, lower=np.broadcast_to(lower, model.n), upper=np.broadcast_to(upper, model.n))


@cache
def found_of(name):
    """The singular set of a robot, or of one with other limits."""
    model = ks.load(name.partition(",")[0])
    if name.endswith("half"):
        model = limited(model, model.lower / 2, model.upper / 2)
    if name.endswith("limits"):
        model = limited(model, [-2.0, 0.3, -1.5], [2.0, 4.0, 4.0])
    return singularities(model)


def postures(found, count, seed):
    """Inside the limits, every fourth moved, which brings most of these outside."""
    q, rng = found.model.random_configurations(count, seed), np.random.default_rng(seed)
    q[::4] += rng.normal(size=q[::4].shape)
    return q


# Laws


@pytest.mark.parametrize("name", [*NAMES, "ur5e"])
def test_the_posture_is_singular_and_inside(name):
    """On the component, exactly inside the limits, of less than full rank, not below the bound or the unlimited distance."""
    found = found_of(name)
    lower, upper = found.model.lower, found.model.upper
    for q in postures(found, 2, seed=2):
        free = {id(d.component): d for d in found.distance(q)}
        inside = found.distance(q, within_limits=True)
        assert [d.value for d in inside] == sorted(d.value for d in inside)
        assert all(d.inside for d in inside)
        for d in inside:
            other = free[id(d.component)]
            assert other.inside is False
            assert d.at_least >= other.at_least * (1 - 1e-12)
            if d.nearest is None:
                continue
            assert np.all((lower <= d.nearest) & (d.nearest <= upper))
            assert np.abs(d.component.residuals(d.nearest[None])[0]).max() <= 1e-9
            assert spectrum(found.model, d.nearest, found.task, found.link)[found.task.rank - 1] <= 1e-9
            assert d.value == pytest.approx(np.linalg.norm(d.nearest - q), rel=1e-12)
            assert d.at_least <= d.value
            assert d.value >= other.value * (1 - 1e-9)
            if np.all((lower <= other.nearest) & (other.nearest <= upper)):
                assert d.value == pytest.approx(other.value, rel=1e-9)


def test_without_limits_it_is_the_same_distance():
    """Continuous joints are free."""
    found = singularities(limited(ks.load("ur5e"), -np.inf, np.inf))
    for q in np.random.default_rng(0).uniform(-9.0, 9.0, (2, 6)):
        pairs = zip(found.distance(q), found.distance(q, within_limits=True), strict=True)
        for free, inside in pairs:
            assert free.component is inside.component
            np.testing.assert_allclose(inside.nearest, free.nearest, atol=1e-7)


def test_the_panda_at_home_has_somewhere_to_go():
    """All five nearest postures are outside its limits; of three components there are others inside, of two none."""
    found = found_of("panda")
    lower, upper = found.model.lower, found.model.upper
    for d in found.distance(found.model.home):
        assert not np.all((lower <= d.nearest) & (d.nearest <= upper))
    inside = found.distance(found.model.home, within_limits=True)
    assert [d.nearest is not None for d in inside] == [True, True, True, False, False]
    assert [d.component.within_limits for d in inside] == [True, True, True, False, False]


def test_whole_turns_inside_wide_limits():
    """The UR5e turns by ±2π: the wrist's nearest of five places is taken, and the limit is not passed for a nearer one."""
    found = found_of("ur5e")
    for angle, place in ((0.4, 0.0), (2.0, np.pi), (-5.0, -2 * np.pi), (6.9, 2 * np.pi), (8.5, 2 * np.pi)):
        q = np.array([0.1, -0.2, 1.0, 0.3, angle, 0.0])
        (wrist,) = [d for d in found.distance(q, within_limits=True) if d.component.name == "wrist"]
        assert wrist.nearest[4] == pytest.approx(place, abs=1e-12)
        np.testing.assert_array_equal(np.delete(wrist.nearest, 4), np.delete(q, 4))


def test_a_planar_arm_by_hand():
    """A 2R arm is singular at q2 = 0 and π. Limits of [0.5, 4] leave π, and joint 1 comes inside by the shortest way."""
    found = singularities(limited(ks.load("planar_2r"), [-1.0, 0.5], [1.0, 4.0]))
    (d,) = found.distance([1.3, 0.7], within_limits=True)
    np.testing.assert_allclose(d.nearest, [1.0, np.pi], atol=1e-12)
    assert d.value == pytest.approx(np.hypot(0.3, np.pi - 0.7), rel=1e-12)
    assert d.at_least == pytest.approx(d.value, rel=1e-8)


def test_limits_that_end_at_a_singular_posture():
    """The limit itself counts as inside; so does one that rounding puts a hair before it."""
    for lower in (0.0, np.nextafter(0.0, 1.0)):
        (d,) = singularities(limited(ks.load("planar_2r"), lower, 2.0)).distance([0.4, 0.3], within_limits=True)
        assert d.nearest[1] == lower


def test_nothing_inside_is_said_with_a_proof_or_without():
    """Limits between two values of one joint prove it; a box beside the PUMA's shoulder surface does not."""
    (d,) = singularities(limited(ks.load("planar_2r"), 0.5, 3.0)).distance([0.0, 1.0], within_limits=True)
    assert (d.value, d.nearest, d.at_least) == (np.inf, None, np.inf)
    assert str(d) == "elbow: no posture is inside the joint limits"
    assert json.loads(json.dumps(d.to_dict(), allow_nan=False))["inside"] is True
    model = ks.load("puma_560")
    q = np.array([0.0, 0.4, -1.0, 0.5, 0.3, 0.2])
    near = singularities(limited(model, q - 0.05, q + 0.05)).distance(q, within_limits=True)
    (shoulder,) = [d for d in near if d.component.name == "shoulder"]
    assert shoulder.nearest is None
    assert 0.05 < shoulder.at_least < np.inf
    assert str(shoulder) == "shoulder: no posture was found inside the joint limits"
    assert str(d) != str(replace(d, inside=False))


def test_the_same_question_has_the_same_answer():
    """To the last bit."""
    found = found_of("panda")
    q = postures(found, 1, seed=5)[0]
    first, second = (found.distance(q, within_limits=True) for _ in range(2))
    for a, b in zip(first, second, strict=True):
        assert (a.value, a.at_least) == (b.value, b.at_least)
        assert a.nearest is b.nearest is None or np.array_equal(a.nearest, b.nearest)


def test_it_says_which_question_it_answers():
    found = found_of("panda")
    inside, free = found.distance(found.model.home, within_limits=True)[0], found.distance(found.model.home)[0]
    assert str(inside).startswith("shoulder: 1.7547 rad (100.5395°) inside the joint limits, at least ")
    assert "inside" not in str(free)


# An independent judge


class Waves:
    """A function of some joints, the others held."""

    def __init__(self, f, columns):
        self.K, self.a, self.b = f.frequencies[:, columns], f.cosines / f.scale, f.sines / f.scale

    def value(self, y):
        phase = self.K @ y
        return self.a @ np.cos(phase) + self.b @ np.sin(phase)

    def gradient(self, y):
        phase = self.K @ y
        return (self.b * np.cos(phase) - self.a * np.sin(phase)) @ self.K


def shortest_inside(optimize, component, q, starts, rng):
    """The shortest way by sequential quadratic programming from random starts in the limits; infinite where none arrives."""
    model, columns = component.space.model, list(component.columns)
    lower, upper, goal = model.lower[columns], model.upper[columns], q[columns]
    low, high = np.where(np.isfinite(lower), lower, goal - np.pi), np.where(np.isfinite(upper), upper, goal + np.pi)
    choices = [[Waves(f, columns) for f in fs] for fs in itertools.product(*(e.functions for e in component.equations))]
    best = np.inf
    for k in range(starts):
        held = choices[k % len(choices)]
        equal = {
            "type": "eq",
            "fun": lambda y, held=held: np.array([f.value(y) for f in held]),
            "jac": lambda y, held=held: np.array([f.gradient(y) for f in held]),
        }
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of starts that are cut to the limits
            result = optimize.minimize(
                lambda y: (y - goal) @ (y - goal), rng.uniform(low, high), jac=lambda y: 2 * (y - goal), method="SLSQP",
                bounds=list(zip(lower, upper, strict=True)), constraints=[equal], options={"ftol": 1e-14, "maxiter": 100},
            )  # fmt: skip
        y = np.clip(result.x, lower, upper)
        if max(abs(f.value(y)) for f in held) <= 1e-9:
            best = min(best, float(np.linalg.norm(y - goal)))
    rest = np.delete(np.clip(q, model.lower, model.upper) - q, columns)
    return float(np.hypot(best, np.linalg.norm(rest)))


def judged(name, queries, starts):
    """(value, bound, the judge's best) for every component and posture."""
    optimize = pytest.importorskip("scipy.optimize", reason="a judge of the dev extra")
    found, rng = found_of(name), np.random.default_rng(1)
    for q in postures(found, queries, seed=7):
        for d in found.distance(q, within_limits=True):
            tries = starts if d.nearest is not None else starts // 8  # those that arrive nowhere take the longest
            yield d.value, d.at_least, shortest_inside(optimize, d.component, q, tries, rng)


def holds(name, queries, starts):
    for value, at_least, best in judged(name, queries, starts):
        assert value <= best * (1 + 1e-6) + 1e-9
        assert at_least <= best * (1 + 1e-6) + 1e-9


@pytest.mark.parametrize("name", NAMES)
def test_none_is_shorter_from_a_few_starts(name):
    holds(name, queries=2, starts=8)


@pytest.mark.nightly
@pytest.mark.parametrize("name", NAMES)
def test_none_is_shorter_from_many_starts(name):
    """200 starts for each of 20 postures."""
    holds(name, queries=20, starts=200)
