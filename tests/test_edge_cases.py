"""Numeric edge cases on the public functions."""

import copy
import locale
import pickle
import sys
import types
import warnings

import mpmath
import numpy as np
import pytest

import kinestatics as ks

ARM = ks.load("panda")


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_configuration_that_is_not_finite_is_refused(value):
    """KS301 names the entry and the joint; check_finite=False lets it through and gives NaN."""
    q = ARM.home.copy()
    q[3] = value
    with pytest.raises(ks.ConfigurationError, match=r"KS301: q\[3\] \(joint 'panda_joint4'\)"):
        ks.jacobian(ARM, q)
    with pytest.raises(ks.ConfigurationError, match=r"q\[1, 3\]"):
        ks.pose(ARM, np.stack([ARM.home, q]))
    assert np.isnan(ks.jacobian(ARM, q, check_finite=False).array).any()


def test_large_angles_are_reduced_exactly_and_warned_about():
    """|q| up to 1e9: sine and cosine of the very double given; above 1e6 a warning says what a double can know."""
    arm = ks.load("planar_2r")
    for size in (1e3, 1e6, 1e7, 1e9):
        q = np.array([size, 0.25])
        with warnings.catch_warnings(record=True) as seen:
            warnings.simplefilter("always")
            tip = ks.pose(arm, q).translation
        assert bool(seen) == (size > 1e6)
        mpmath.mp.dps = 40
        exact = [
            mpmath.cos(size) + mpmath.cos(mpmath.mpf(size) + 0.25),
            mpmath.sin(size) + mpmath.sin(mpmath.mpf(size) + 0.25),
        ]
        np.testing.assert_allclose(tip[:2], [float(x) for x in exact], atol=4e-16)


@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_measures_of_arms_with_few_joints(n):
    """Fewer than six joints: measures use the rows in play and min(rows, n), and see a stretched arm as singular."""
    arm = ks.from_dh([(0.3, 0, 0, 0)] * n, convention="standard")
    ev = ks.Evaluator(arm)
    assert ev.singular_values(np.full(n, 0.4)).shape == (min(n, len(ev.task.rows)),)
    stretched = ks.analyze(arm, np.zeros(n))
    assert stretched.is_singular == (n > 1)
    assert stretched.task.row_names[:2] == ("vx", "vy")


@pytest.mark.parametrize("n", [100, 1000])
def test_many_joints(n):
    """100 and 1,000 joints work, without recursion."""
    arm = ks.from_dh([(0.01, 0.3, 0.002, 0.1)] * n, convention="standard")
    J = ks.jacobian(arm, np.linspace(-1, 1, n))
    assert J.array.shape == (6, n)
    step = 1e-6
    moved = [ks.pose(arm, np.linspace(-1, 1, n) + s * step * np.eye(n)[n // 2]).translation for s in (1, -1)]
    np.testing.assert_allclose(J.linear[:, n // 2], (moved[0] - moved[1]) / (2 * step), atol=1e-8)


@pytest.mark.parametrize("length", [5e-324, 1e-320, 1e-30, 1e9])
def test_tiny_and_huge_lengths(length):
    """Subnormal to planetary lengths: finite, and proportional."""
    arm = ks.from_dh([(length, 0, 0, 0), (length, 0, 0, 0)], convention="standard")
    J = ks.jacobian(arm, [0.0, 0.0])
    np.testing.assert_allclose(J.linear[1], [2 * length, length], rtol=1e-15)
    assert np.all(np.isfinite(ks.Evaluator(arm).singular_values([0.3, 0.4])))


def test_exactly_singular_postures_have_exact_ranks():
    """All joints parallel, coincident axes, zero-length links: the rank is what geometry says, without a warning."""
    parallel = ks.from_dh([(0.0, 0, 0, 0)] * 3, convention="standard")
    analysis = ks.analyze(parallel, np.zeros(3), task="full")
    assert analysis.rank == 1
    assert len(analysis.lost_twists) == 5
    wrist = ks.analyze(ks.load("puma_560"), [0.1, 0.4, -1.0, 0.3, 0.0, 0.2])
    assert wrist.rank == 5
    both = ks.analyze(ks.load("puma_560"), [0.0, 0.0, np.arctan2(0.4318, -0.0203) - np.pi, 0.3, 0.0, 0.2])
    assert both.rank <= 5


def test_prismatic_joints_only():
    """A gantry: position only, singular nowhere, no rotation."""
    half = np.pi / 2
    arm = ks.from_dh([(0, half, 0, 0), (0, half, 0, half), (0, 0, 0, 0)], convention="standard", types="PPP")
    analysis = ks.analyze(arm, [0.1, 0.2, 0.3])
    assert analysis.task.row_names == ("vx", "vy", "vz")
    assert analysis.rank == 3
    assert not np.any(analysis.jacobian.angular)


def test_no_masses_is_an_error_and_not_a_zero():
    """Gravity of an arm without masses is refused; with a massless link in between it is computed."""
    with pytest.raises(ks.MissingMassError, match="KS320"):
        ks.gravity_torques(ARM, ARM.home)
    assert ks.analyze(ARM).gravity_torques is None
    arm = ks.from_dh([(1, 0, 0, 0)] * 2, convention="standard", masses=[0, 1], centers_of_mass=[(0, 0, 0)] * 2)
    assert np.all(np.isfinite(ks.gravity_torques(arm, [0.0, 0.0])))


def test_models_and_results_are_immutable():
    """Nothing can be written into a model, a Jacobian or a pose's description; inputs are not kept."""
    with pytest.raises(AttributeError):
        ARM.name = "other"
    with pytest.raises(ValueError, match="read-only"):
        ARM.lower[0] = 0
    q = ARM.home.copy()
    J = ks.jacobian(ARM, q)
    with pytest.raises(AttributeError, match="immutable"):
        J.frame = ks.Frame.spatial()
    before = J.change_frame(ks.Frame.body()).array
    q[:] = 0
    assert np.array_equal(J.change_frame(ks.Frame.body()).array, before)


@pytest.mark.parametrize(
    "again", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))], ids=["copy", "deepcopy", "pickle"]
)
def test_models_and_results_copy_and_pickle(again):
    """A copy computes the same bits."""
    J = ks.jacobian(ARM, ARM.home)
    assert np.array_equal(ks.jacobian(again(ARM), ARM.home).array, J.array)
    assert np.array_equal(again(J).change_frame(ks.Frame.body()).array, J.change_frame(ks.Frame.body()).array)
    assert np.array_equal(again(ks.Evaluator(ARM)).jacobian(ARM.home), J.array)
    assert str(again(ks.pose(ARM, ARM.home))) == str(ks.pose(ARM, ARM.home))
    error = again(ks.ConfigurationError("KS301", "message", "hint"))
    assert (error.code, str(error)) == ("KS301", "error KS301: message\n  hint: hint")


def test_a_decimal_comma_locale_changes_nothing():
    """Numbers are read and printed with a point, whatever the locale."""
    before = locale.setlocale(locale.LC_NUMERIC)
    for name in ("de_DE.UTF-8", "de_DE", "C"):
        try:
            locale.setlocale(locale.LC_NUMERIC, name)
            break
        except locale.Error:
            continue
    try:
        assert "0.088" in str(ks.pose(ARM, np.zeros(7)))
    finally:
        locale.setlocale(locale.LC_NUMERIC, before)


def test_same_input_same_output():
    """Random configurations depend on their seed alone."""
    assert np.array_equal(ARM.random_configurations(5, seed=3), ARM.random_configurations(5, seed=3))
    assert not np.array_equal(ARM.random_configurations(5, seed=3), ARM.random_configurations(5, seed=4))
    q = ARM.random_configurations(1000, seed=0)
    assert np.all((q >= ARM.lower) & (q <= ARM.upper))


@pytest.mark.parametrize("gravity", [(0, 0), (0, 0, -9.81, 0), (0, 0, np.nan), "down", None, 9.81, (0, 0, np.inf)], ids=str)
def test_gravity_that_is_no_vector_is_refused(gravity):
    """Gravity is three finite numbers; anything else is an error and not a NaN or an index error."""
    arm = ks.load("planar_2r")
    for ask in (
        lambda: ks.gravity_torques(arm, [0.1, 0.2], gravity=gravity),
        lambda: ks.analyze(arm, gravity=gravity),
        lambda: ks.Evaluator(arm, gravity=gravity),
    ):
        with pytest.raises(ks.ConfigurationError, match="KS303: gravity"):
            ask()


def test_random_configurations_need_counts_and_seeds_from_zero():
    """A negative seed or count is an error with a code."""
    for count, seed in ((1, -1), (-1, 0)):
        with pytest.raises(ks.ConfigurationError, match="KS309"):
            ARM.random_configurations(count, seed)


def test_numbers_are_numbers_while_another_thread_imports_sympy(monkeypatch):
    """A module that is half imported has none of its names yet; nothing can be a symbol then."""
    monkeypatch.setitem(sys.modules, "sympy", types.ModuleType("sympy"))
    arm = ks.from_dh([(1, 0, 0, 0), (1, 0, 0, 0)], convention="standard")
    assert ks.jacobian(arm, [0.0, 0.5]).shape == (6, 2)
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        ks.jacobian(arm, np.array(["a", "b"], dtype=object))
