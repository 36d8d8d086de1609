"""Arms with many general angles, such as calibrated ones: rotations of fractions, a determinant of some hundred waves."""

import numpy as np
import pytest
import sympy

import kinestatics as ks
from kinestatics.singular_sets import singularities

SEEDS = (0, 1, 2)


def general_arm(seed, wrist=False):
    """Six joints with random lengths, twists and offsets; with a wrist, the last three axes meet in a point."""
    rng = np.random.default_rng(seed)
    table = np.column_stack([rng.uniform(0.1, 1, 6), rng.uniform(-3, 3, 6), rng.uniform(0.1, 1, 6), rng.uniform(-3, 3, 6)])
    if wrist:
        table[3:5, 0] = table[4, 2] = table[5, 0] = table[5, 2] = 0.0
    return ks.from_dh(table.tolist(), convention="standard")


def determinants(arm, q):
    return np.linalg.det(ks.jacobian(arm, q).array)


@pytest.mark.parametrize("seed", SEEDS)
def test_rotations_of_fractions_are_rotations(seed):
    """Exactly orthonormal, of fractions, and within 1e-13 of those given; lengths keep twelve digits."""
    arm = general_arm(seed)
    exact = ks.exact(arm, angles="fractions")
    for T in (*exact.placements, *exact.link_placements):
        R = sympy.Matrix(T[:3, :3])
        assert sympy.eye(3) == R * R.T
        assert R.det() == 1
        assert all(x.is_Rational for x in R)
    for screw in exact.screws:
        assert sum(x * x for x in screw[3:]) == 1
    numbers = exact.map(lambda a: np.array([float(x) for x in a.flat]).reshape(a.shape))
    q = np.random.default_rng(seed).uniform(-3, 3, (50, 6))
    mine, given = ks.pose(numbers, q), ks.pose(arm, q)
    assert np.abs(mine.rotation - given.rotation).max() < 1e-13
    assert np.abs(mine.translation - given.translation).max() < 1e-11


@pytest.mark.parametrize("placement", [0, 1])
def test_turns_about_one_axis_stay_turns_about_it(placement):
    """What is zero stays zero: a quarter turn and a turn by 0.4 rad about x."""
    arm = ks.from_dh([(0.3, [0.4, np.pi / 2][placement], 0.1, 0)] * 3, convention="standard")
    exact = ks.exact(arm, angles="fractions")
    assert ((np.abs(np.asarray(arm.placements, float)) < 1e-12) == (exact.placements == 0)).all()


@pytest.mark.parametrize("seed", SEEDS)
def test_determinant_is_the_sum_of_its_waves(seed):
    """At most 225 terms; 1e-10 of the greatest value; and the expression in decimals is the same."""
    arm = general_arm(seed)
    found = singularities(arm)
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (1000, 6))
    known = determinants(arm, q)
    waves = found.fourier
    assert found.complete
    assert np.abs(waves.value(q) - known).max() <= 1e-11 * np.abs(known).max()
    assert np.count_nonzero(waves.cosines) + np.count_nonzero(waves.sines) <= 225
    function = sympy.lambdify(sorted(found.determinant.free_symbols, key=str), found.determinant, "numpy")
    assert np.abs(function(*q[:, 1:5].T) - known).max() <= 1e-10 * np.abs(known).max()
    assert found.residual < 1e-11
    assert len(str(found)) < 700


def test_it_is_irreducible_and_sound():
    """One factor; all points of it lose rank; a box there is singular, one away from it is free."""
    arm = general_arm(0)
    found = singularities(arm)
    (component,) = found.components
    assert component.sound
    assert component.verified == "24 of 24 points lose rank"
    on = component.points[0]
    assert found.certify_free((on - 0.02, on + 0.02)).verdict == "singular"
    q = np.random.default_rng(5).uniform(-np.pi, np.pi, (200, 6))
    far = q[np.abs(determinants(arm, q)).argmax()]
    assert found.certify_free((far - 0.02, far + 0.02)).verdict == "free"
    near = found.distance(far)[0]
    assert near.at_least <= near.value
    assert np.linalg.svd(ks.jacobian(arm, near.nearest).array, compute_uv=False)[-1] < 1e-9


@pytest.mark.parametrize("seed", SEEDS)
def test_axes_that_meet_still_make_a_factor(seed):
    """With three axes that meet behind general twists the determinant has the wrist's factor, whose joint is the fifth."""
    found = singularities(general_arm(seed, wrist=True))
    assert [c.joints for c in found.components if c.name == "wrist"] == [("joint5",)]
    assert {e.columns for e, _ in found.factors} == {(4,), (1, 2)}


def test_progress_is_told_and_may_end_the_search():
    """Words and shares arrive; an exception comes through."""
    told = []
    singularities(ks.load("panda"), progress=lambda what, share: told.append((what, share)))
    assert {what for what, _ in told} == {"determinants", "splitting conditions", "points of components"}
    assert all(share is None or 0 <= share <= 1 for _, share in told)

    def stop(*_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        singularities(ks.load("panda"), progress=stop)


def test_closed_forms_hold_for_them():
    """Determinant and Jacobian as expressions of numbers with at most 17 digits, and code that checks itself."""
    arm = general_arm(0)
    form = ks.closed_form("determinant", arm)
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (100, 6))
    function = sympy.lambdify(form.symbols["joints"], form.expression, "numpy")
    known = determinants(arm, q)
    assert np.abs(function(*q.T) - known).max() <= 1e-10 * np.abs(known).max()
    assert "def determinant(q)" in ks.generate_code(form, language="numpy")
    J = ks.closed_form("jacobian", arm)
    function = sympy.lambdify(J.symbols["joints"], J.expression, "numpy")
    assert np.abs(function(*q[0]) - ks.jacobian(arm, q[0], frame=J.frame).array).max() < 1e-10
