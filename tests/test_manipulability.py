"""Measures, gradients and ellipsoids: known numbers, libraries, symbols, singular postures, text, and mistakes."""

import json
import warnings
from pathlib import Path

import jax
import numpy as np
import pytest
import sympy as sp
import torch

import kinestatics as ks

GOLDEN = Path(__file__).parent / "golden"
CASES = {case["id"]: case for case in json.loads((GOLDEN / "truth_cases.json").read_text(encoding="utf-8"))["cases"]}
MEASURES = (
    ks.singular_values,
    ks.manipulability,
    ks.smallest_singular_value,
    ks.inverse_condition,
    ks.condition_number,
    ks.isotropy,
)
PUMA, QN = ks.load("puma_560"), np.array([0, np.pi / 4, np.pi, 0, np.pi / 4, 0])
PLANAR = ks.load("planar_2r")
THETA = sp.symbols("theta1:4", real=True)
A = sp.symbols("a1:4", positive=True)


def lengths_of(arm):
    return {"length": ks.characteristic_length(arm)}


def elementary(kind, value):
    """The homogeneous matrix of one element: Rx ... tz."""
    T, i = np.eye(4), "xyz".index(kind[1])
    if kind[0] == "t":
        T[i, 3] = value
        return T
    c, s, (j, k) = np.cos(value), np.sin(value), [(1, 2), (2, 0), (0, 1)][i]
    T[j, j], T[j, k], T[k, j], T[k, k] = c, -s, s, c
    return T


def arm_of_elements(elements):
    """An arm from a sequence of elementary transforms, through its screws at zero."""
    T, screws = np.eye(4), []
    for element in elements:
        if "value" in element:
            T = T @ elementary(element["et"], element["value"])
        else:
            axis = T[:3, "xyz".index(element["et"][1])]
            screws.append(ks.screw_axis(axis, T[:3, 3]))
    return ks.from_screws(screws, T, order="linear-angular")


# -- numbers of others ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [name for name in CASES if "manip-gradient" in name])
def test_printed_gradients(name):
    """Gradients that the Robotics Toolbox prints for the Panda, all rows and the angular ones."""
    case = CASES[name]
    arm = arm_of_elements(case["robot"]["elements"])
    task = "orientation" if "axes=rot" in case["quantity"] else "auto"
    found = ks.manipulability_gradient(arm, case["q"], task=task)
    np.testing.assert_allclose(found, case["expected"], atol=case["tolerance"]["atol"])


def test_printed_gradients_are_three():
    assert len([name for name in CASES if "manip-gradient" in name]) == 3


def puma_mass_matrix(rows, arm, q):
    """Σ m JᵀJ + Jωᵀ I Jω over the links, and the rotors behind their gears."""
    M = np.diag([row["Jm"] * row["G"] ** 2 for row in rows])
    for link, row in zip(arm.link_names[1:], rows, strict=True):
        J, R = ks.jacobian(arm, q, at=link, point=row["com"]), ks.pose(arm, q, at=link).rotation
        turning = R.T @ J.angular
        M = M + row["m"] * J.linear.T @ J.linear + turning.T @ np.diag(row["I"]) @ turning
    return M


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("rtbp-puma-asada-qn", {"length": 1.0}),
        ("rtbp-puma-asada-trans-qn", {"task": "position", "others": "held"}),
        ("rtbp-puma-asada-rot-qn", {"task": "orientation", "others": "held"}),
    ],
)
def test_printed_asada(name, options):
    """Asada's measure as the Robotics Toolbox prints it: rotors counted, other rows held, metres and radians as they are."""
    case = CASES[name]
    rows = case["robot"]["rows"]
    arm = ks.from_dh([(row["a"], row["alpha"], row["d"], 0.0) for row in rows], convention="standard")
    M = puma_mass_matrix(rows, arm, case["q"])
    found = ks.asada(ks.jacobian(arm, case["q"]), M, **options)
    np.testing.assert_allclose(found, case["expected"], atol=case["tolerance"]["atol"])


def test_the_spherical_arm_of_note_000():
    """J_v J_vᵀ = diag(1, d3², d3²) at (0, 0, d3), worked example 000.spherical.ellipsoid."""
    e = ks.velocity_ellipsoid(ks.jacobian(ks.load("rrp_note_000"), [0.0, 0.0, 0.6]))
    assert e.rows == ("vx", "vy", "vz")
    np.testing.assert_allclose(e.axes * e.radii**2 @ e.axes.T, np.diag([1.0, 0.36, 0.36]), atol=1e-15)


def test_manipulability_of_note_000():
    """a1 a2 |sin θ2|, worked example 000.planar.mu, in symbols and in numbers."""
    arm = ks.from_dh([(a, 0, 0, 0) for a in A[:2]], convention="standard")
    J = ks.jacobian(arm, THETA[:2])
    expected = A[0] * A[1] * sp.Abs(sp.sin(THETA[1]))
    assert ks.manipulability(J) == expected
    assert ks.manipulability(J.array[:2]) == expected
    assert ks.manipulability(J, task="position") == expected
    q = np.random.default_rng(0).uniform(-3, 3, (50, 2))
    np.testing.assert_allclose(ks.manipulability(ks.jacobian(PLANAR, q)), np.abs(np.sin(q[:, 1])), atol=1e-15)


def test_half_of_the_digits_are_not_lost():
    """√det(J Jᵀ) knows nothing below 1e-8; products of singular values do."""
    for angle in (1e-6, 1e-9, 1e-12):
        J = ks.jacobian(PLANAR, [0.3, angle])
        np.testing.assert_allclose(ks.manipulability(J), np.sin(angle), rtol=1e-9, atol=3e-16)


def test_radii_of_the_puma():
    """σ(J_v) = 0.690, 0.613, 0.263 at qn, in base axes: other packages draw 1/σ, or tool axes, under the same name."""
    e = ks.velocity_ellipsoid(ks.jacobian(PUMA, QN), task="position")
    np.testing.assert_allclose(e.radii, [0.690, 0.613, 0.263], atol=5e-4)
    J = ks.jacobian(PUMA, QN).linear
    np.testing.assert_allclose(J @ J.T @ e.axes, e.axes * e.radii**2, atol=1e-14)
    assert (e.kind, e.rows, e.unit, str(e.frame)) == (
        "velocity",
        ("vx", "vy", "vz"),
        "m/s",
        "axes of base, at the origin of tip",
    )
    f = ks.force_ellipsoid(ks.jacobian(PUMA, QN), task="position")
    np.testing.assert_allclose(f.radii, [1.45, 1.63, 3.80], atol=5e-3)
    assert (f.rows, f.unit) == (("fx", "fy", "fz"), "N")
    in_tool = ks.velocity_ellipsoid(ks.jacobian(PUMA, QN, frame=ks.Frame.body()), task="position")
    R = ks.pose(PUMA, QN).rotation
    np.testing.assert_allclose(np.abs((R @ in_tool.axes).T @ e.axes), np.eye(3), atol=1e-12)


@pytest.mark.parametrize("name", ["ur5e", "panda", "elbow_rrr"])
def test_pycapacity_agrees(name):
    """Radii and axes of both ellipsoids with joint limits, from another package."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it imports numpy.matlib
        import pycapacity.robot as pycapacity
    arm = ks.load(name)
    rng = np.random.default_rng(1)
    speeds, torques = rng.uniform(1, 3, arm.n), rng.uniform(10, 80, arm.n)
    J = ks.jacobian(arm, arm.random_configurations(1, seed=4)[0])
    for found, theirs in (
        (ks.velocity_ellipsoid(J, task="position", joint_scale=speeds), pycapacity.velocity_ellipsoid(J.linear, speeds)),
        (ks.force_ellipsoid(J, task="position", joint_scale=torques), pycapacity.force_ellipsoid(J.linear, torques)),
    ):
        np.testing.assert_allclose(found.radii, theirs.radii, rtol=1e-10)
        np.testing.assert_allclose(np.abs(theirs.rotation.T @ found.axes), np.eye(3), atol=1e-9)


# -- rows in play ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ks.catalogue_names())
def test_every_arm_of_the_catalogue_is_measured_in_its_own_freedoms(name):
    """Not 0 for planar and few-joint arms; the same as the analysis and the Evaluator; KS360 exactly where rows mix."""
    arm = ks.load(name)
    for q in arm.random_configurations(3, seed=7):
        a = ks.analyze(arm, q)
        J, length = a.jacobian, a.characteristic_length
        assert ks.manipulability(J) == a.manipulability > 0
        np.testing.assert_allclose(ks.manipulability(J), ks.Evaluator(arm).manipulability(q), rtol=1e-9)
        np.testing.assert_allclose(ks.condition_number(J, length=length), a.condition, rtol=1e-12)
        sigma = ks.singular_values(J, length=length)
        np.testing.assert_allclose(sigma, a.singular_values, rtol=1e-12, atol=1e-15)
        assert ks.smallest_singular_value(J, length=length) == sigma[a.task.rank - 1] > 0
        e = ks.velocity_ellipsoid(J, length=length)
        np.testing.assert_allclose(e.radii[: a.task.rank], sigma[: a.task.rank], rtol=1e-12)
        assert not np.any(e.radii[a.task.rank :])
        if "angular rows" in a.scaled:
            with pytest.raises(ks.ConfigurationError, match="KS360"):
                ks.condition_number(J)
        else:
            assert ks.condition_number(J) >= 1
        assert e.characteristic_length == (length if a.scaled else None)


def test_planar_arm_of_three_joints():
    """Its own rows are vx, vy, wz; J.linear has a row of zeros, and is measured as it stands."""
    arm = ks.load("planar_3r")
    J = ks.jacobian(arm, [0.1, 0.7, -0.4])
    assert ks.manipulability(J) > 0.1
    assert ks.manipulability(J.linear) < 1e-16
    np.testing.assert_allclose(ks.manipulability(J, task="position"), ks.manipulability(J.array[:2]), rtol=1e-12)
    assert ks.velocity_ellipsoid(J.linear).is_flat
    assert ks.condition_number(J.linear) == np.inf


def test_length_matters_only_where_units_meet():
    """One unit in rows and joints: it changes nothing. Prismatic and revolute columns are weighed, unless by scales."""
    J = ks.jacobian(PUMA, QN)
    for task in ("position", "orientation"):
        assert ks.condition_number(J, task=task, length=0.3) == ks.condition_number(J, task=task)
    K = ks.jacobian(ks.load("stanford_arm"), [0.1, 0.5, 0.4, 0.3, 0.9, 0.2])
    weighed = np.linalg.svd(K.linear * [1, 1, 0.3, 1, 1, 1], compute_uv=False)
    np.testing.assert_allclose(ks.singular_values(K, task="position", length=0.3), weighed, rtol=1e-12)
    scale = np.array([1.0, 2, 3, 4, 5, 6])
    e = ks.velocity_ellipsoid(K, task="position", length=0.3, joint_scale=scale)
    np.testing.assert_allclose(e.radii, np.linalg.svd(K.linear * scale, compute_uv=False), rtol=1e-12)
    assert e.characteristic_length is None
    M = np.diag(scale)
    assert ks.asada(K, M, task="position", length=0.3) == ks.asada(K.linear, M)


# -- gradients at kinks ---------------------------------------------------------------------------------------------------


def test_gradient_where_two_singular_values_meet():
    """A planar arm with a1 = √2 a2 is isotropic at θ2 = 135°: no step makes it rounder; σ1 and σ2 have different slopes."""
    arm = ks.from_dh([(np.sqrt(2), 0, 0, 0), (1.0, 0, 0, 0)], convention="standard")
    q = np.array([0.4, 0.75 * np.pi])
    J = ks.jacobian(arm, q)
    np.testing.assert_allclose([ks.condition_number(J), ks.isotropy(J)], 1.0, atol=1e-12)
    for measure in ("inverse_condition", "isotropy"):
        np.testing.assert_allclose(ks.manipulability_gradient(arm, q, measure=measure), 0.0, atol=1e-12)
    step = np.array([0.0, 1e-6])
    slopes = (ks.singular_values(ks.jacobian(arm, q + step)) - ks.singular_values(ks.jacobian(arm, q - step))) / 2e-6
    found = ks.manipulability_gradient(arm, q, measure="smallest_singular_value")
    np.testing.assert_allclose(found, [0.0, np.mean(slopes)], atol=1e-8)
    np.testing.assert_allclose(ks.manipulability_gradient(arm, q), [0.0, np.sqrt(2) * np.cos(q[1])], atol=1e-12)


def test_gradient_where_two_singular_values_vanish():
    """Elbow stretched under the tip on the first axis: w is of second order, and no direction can be named."""
    arm, q = ks.load("elbow_rrr"), np.array([0.3, np.pi / 2, 0.0])
    for measure in ("manipulability", "smallest_singular_value", "inverse_condition", "isotropy"):
        np.testing.assert_array_equal(ks.manipulability_gradient(arm, q, measure=measure), np.zeros(3))
    steps = 1e-4 * np.random.default_rng(0).normal(size=(50, 3))
    assert np.all(ks.manipulability(ks.jacobian(arm, q + steps)) < 1e-6)


def test_isotropy_rises_infinitely_fast_from_a_singularity():
    """w^(2/k) with k > 2 has a vertical slope: infinite entries along the steepest ascent, NaN where there is none."""
    options = {"measure": "isotropy", "length": 1.0}
    wrist = ks.manipulability_gradient(ks.load("ur5e"), [0.1, -1.0, 1.2, 0.3, 0.0, 0.2], **options)
    np.testing.assert_array_equal(wrist, [0, 0, 0, 0, np.inf, 0])
    assert np.all(np.isnan(ks.manipulability_gradient(ks.load("iiwa_14"), np.zeros(7), **options)))
    stretched = ks.manipulability_gradient(PLANAR, [0.2, 0.0], measure="isotropy")
    np.testing.assert_allclose(stretched, [0, ks.isotropy(ks.jacobian(PLANAR, [0.2, 1e-6])) / 1e-6], rtol=1e-5, atol=1e-12)


def test_gradients_in_batches():
    """One posture regular, one singular, one NaN: each as if alone."""
    q = np.array([[0.3, 0.8], [0.3, 0.0], [np.nan, 0.1]])
    for measure in ("manipulability", "smallest_singular_value", "inverse_condition", "isotropy"):
        found = ks.manipulability_gradient(PLANAR, q, measure=measure, check_finite=False)
        for row, posture in zip(found[:2], q[:2], strict=True):
            np.testing.assert_allclose(row, ks.manipulability_gradient(PLANAR, posture, measure=measure), atol=1e-15)
        assert np.all(np.isnan(found[2]))
    assert ks.manipulability_gradient(PLANAR, np.zeros((0, 2))).shape == (0, 2)
    still = ks.from_screws(np.zeros((0, 6)), np.eye(4), order="linear-angular")
    assert ks.manipulability_gradient(still, np.zeros((4, 0))).shape == (4, 0)


# -- libraries ------------------------------------------------------------------------------------------------------------


@pytest.fixture
def double():
    """JAX with float64, as it was before afterwards."""
    before = jax.config.read("jax_enable_x64")
    jax.config.update("jax_enable_x64", True)
    yield
    jax.config.update("jax_enable_x64", before)


GRADIENTS = ("manipulability", "smallest_singular_value", "inverse_condition", "isotropy")


@pytest.mark.usefixtures("double")
def test_gradients_of_jax_and_pytorch():
    """jit, vmap and derivatives of the measures, and `manipulability_gradient` of the libraries' own arrays."""
    arm, options = PLANAR, {"task": ("vx", "wz"), "length": 0.7}
    q = arm.random_configurations(3, seed=2)
    expected = np.stack([ks.manipulability_gradient(arm, q, measure=name, **options) for name in GRADIENTS], axis=-2)

    def values(x):
        J = ks.jacobian(arm, x)
        return [getattr(ks, name)(J, **options) for name in GRADIENTS]

    derivatives = jax.jit(jax.vmap(jax.jacfwd(lambda x: jax.numpy.stack(values(x)))))
    np.testing.assert_allclose(derivatives(q), expected, atol=1e-12)
    ours = jax.jit(lambda x: [ks.manipulability_gradient(arm, x, measure=name, **options) for name in GRADIENTS])
    np.testing.assert_allclose(np.stack(ours(q), axis=-2), expected, atol=1e-12)
    tensor = torch.tensor(q)
    for k, name in enumerate(GRADIENTS):
        leaf = torch.tensor(q, requires_grad=True)
        values(leaf)[k].sum().backward()
        np.testing.assert_allclose(leaf.grad.numpy(), expected[:, k], atol=1e-12)
        found = ks.manipulability_gradient(arm, tensor, measure=name, **options)
        np.testing.assert_allclose(found.numpy(), expected[:, k], atol=1e-12)


@pytest.mark.usefixtures("double")
def test_measures_of_jax_and_pytorch():
    """The same numbers as NumPy, of bare rows and of a Jacobian, regular and singular, in single precision too."""
    q = np.array([[0.3, 0.8], [0.3, 0.0]])
    by_numpy, single = ks.jacobian(PLANAR, q), ks.jacobian(PLANAR, q.astype(np.float32))

    def every(x):
        J = ks.jacobian(PLANAR, x)
        return [function(rows) for function in MEASURES for rows in (J, J.array[..., :2, :])]

    for found in (jax.jit(every)(q), every(torch.tensor(q))):
        for function, pair in zip(MEASURES, zip(found[::2], found[1::2], strict=True), strict=True):
            for values in pair:
                np.testing.assert_allclose(np.asarray(values), function(by_numpy), rtol=1e-12, atol=1e-15)
    for function in MEASURES:
        assert function(single).dtype == np.float32
        np.testing.assert_allclose(function(single), function(by_numpy), rtol=1e-5, atol=1e-6)
    assert np.isinf(ks.condition_number(single)).tolist() == [False, True]


@pytest.mark.usefixtures("double")
def test_asada_and_ellipsoids_of_other_libraries():
    rows, M = np.random.default_rng(3).normal(size=(2, 3, 4)), np.diag([1.0, 2, 3, 4])
    expected = ks.asada(rows, M)
    np.testing.assert_allclose(jax.jit(ks.asada)(jax.numpy.asarray(rows), jax.numpy.asarray(M)), expected, rtol=1e-12)
    np.testing.assert_allclose(ks.asada(torch.tensor(rows), M).numpy(), expected, rtol=1e-12)
    np.testing.assert_allclose(ks.asada(rows, np.stack([M, M])), expected, rtol=1e-14)
    np.testing.assert_allclose(ks.asada(rows[0], np.stack([M, 2 * M])), expected[0], rtol=1e-12)
    e = ks.velocity_ellipsoid(torch.tensor(rows, requires_grad=True))
    np.testing.assert_allclose(e.radii, ks.velocity_ellipsoid(rows).radii, rtol=1e-14)


# -- symbols --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("task", "functions"), [("auto", MEASURES), (("vx",), MEASURES[:3]), (("vx", "wz"), (ks.manipulability, ks.isotropy))]
)
def test_closed_forms_are_the_numbers(task, functions):
    """Closed forms at random lengths and angles, for a planar arm of two joints and several choices of rows."""
    arm = ks.from_dh([(a, 0, 0, 0) for a in A[:2]], convention="standard")
    J, rng = ks.jacobian(arm, THETA[:2]), np.random.default_rng(0)
    options, exact = ({"length": 0.5}, {"length": sp.Rational(1, 2)}) if task == ("vx", "wz") else ({}, {})
    closed = {f: np.asarray(f(J, task=task, **exact), dtype=object) for f in functions}
    for _ in range(3):
        a, q = rng.uniform(0.5, 2, 2), rng.uniform(-3, 3, 2)
        values = dict(zip((*A[:2], *THETA[:2]), (*a, *q), strict=True))
        numbers = ks.jacobian(ks.from_dh([(x, 0, 0, 0) for x in a], convention="standard"), q)
        for function, form in closed.items():
            found = [float(entry.subs(values)) for entry in form.reshape(-1)]
            expected = np.reshape(function(numbers, task=task, **options), -1)
            np.testing.assert_allclose(found[: len(expected)], expected[: len(found)], rtol=1e-10, atol=1e-8)


def test_symbols_of_redundant_and_plain_arms():
    """The Gram determinant of a redundant arm; numbers for lengths; batches; a symbol for the length."""
    arm = ks.from_dh([(a, 0, 0, 0) for a in A], convention="standard")
    J = ks.jacobian(arm, THETA)
    assert ks.manipulability(J) == A[0] * A[1] * sp.Abs(sp.sin(THETA[1]))
    values = dict(zip((*A, *THETA), (0.5, 0.4, 0.2, 0.1, 0.7, -0.4), strict=True))
    number = ks.manipulability(ks.jacobian(ks.load("planar_3r"), [0.1, 0.7, -0.4]), task="position")
    assert float(ks.manipulability(J, task="position").subs(values)) == pytest.approx(number, rel=1e-12)
    plain = ks.manipulability(ks.jacobian(PLANAR, sp.symbols("x y", real=True)))
    assert sp.simplify(plain - sp.Abs(sp.sin(sp.Symbol("y", real=True)))) == 0
    scara = ks.manipulability(ks.jacobian(ks.load("scara"), sp.symbols("q1:5", real=True)))
    assert scara == sp.Rational(143, 1600) * sp.Abs(sp.sin(sp.Symbol("q2", real=True)))  # 0.325 m times 0.275 m
    batch = np.array([[THETA[0], THETA[1]], [0, sp.pi / 2]], dtype=object)
    assert list(ks.manipulability(ks.jacobian(PLANAR, batch))) == [sp.Abs(sp.sin(THETA[1])), 1]
    assert ks.singular_values(ks.jacobian(PLANAR, batch)).shape == (2, 2)
    L = sp.Symbol("L", positive=True)
    assert ks.manipulability(J, length=L) == L * A[0] * A[1] * sp.Abs(sp.sin(THETA[1]))
    assert ks.condition_number(np.array([[sp.Symbol("c"), 0], [0, 0]])) == sp.oo


# -- shapes, edges, drawings ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shape", [(), (0,), (3,), (2, 3)])
def test_batches(shape):
    """Every measure and both ellipsoids of a batch are those of its members; the inputs are left alone."""
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(*shape, 3, 4))
    before = rows.copy()
    for function in MEASURES:
        found = function(rows)
        single = [function(member) for member in rows.reshape(-1, 3, 4)]
        np.testing.assert_array_equal(found.ravel(), np.ravel(single))
    for make in (ks.velocity_ellipsoid, ks.force_ellipsoid):
        e = make(rows, joint_scale=np.arange(1.0, 5.0))
        assert (e.radii.shape, e.axes.shape, e.center.shape) == ((*shape, 3), (*shape, 3, 3), (*shape, 3))
        assert np.shape(e.volume) == np.shape(e.is_flat) == np.shape(e.support([0, 0, 1])) == shape
        assert np.shape(e.contains(np.zeros(3))) == shape
        assert e.points(6).shape == (3, *shape, 6, 6)
        flat = make(rows[..., :2, :])
        assert flat.points(6).shape == (*shape, 6, 2)
    np.testing.assert_array_equal(rows, before)


@pytest.mark.parametrize(("r", "n"), [(0, 3), (3, 0), (0, 0)])
def test_nothing_to_measure(r, n):
    """No rows or no joints: no manipulability, infinite condition, flat velocity and unbounded force ellipsoids."""
    rows = np.zeros((2, r, n))
    assert ks.singular_values(rows).shape == (2, 0)
    for function, value in zip(MEASURES[1:], (0, 0, 0, np.inf, 0), strict=True):
        np.testing.assert_array_equal(function(rows), [value, value])
    np.testing.assert_array_equal(ks.asada(rows, np.eye(n)), [0, 0])
    e, f = ks.velocity_ellipsoid(rows), ks.force_ellipsoid(rows)
    np.testing.assert_array_equal(e.radii, np.zeros((2, r)))
    np.testing.assert_array_equal(f.radii, np.full((2, r), np.inf))
    assert np.all(e.is_flat) == (r > 0)
    assert np.all(f.is_bounded) == (r == 0)


def test_numbers_of_any_size():
    """NaN stays where it is; huge and tiny entries give no warning and no wrong ratio."""
    rows = np.stack([np.diag([2.0, 1.0]), np.full((2, 2), np.nan), np.diag([np.inf, 1.0])])
    for function in MEASURES:
        found = function(rows)
        assert np.all(np.isfinite(found[0]))
        assert np.all(np.isnan(found[1:]))
    assert np.all(np.isnan(ks.velocity_ellipsoid(rows).radii[1:]))
    for size in (1e-300, 1e-160, 1e160, 1e300):
        big = size * np.diag([2.0, 1.0, 1.0])
        np.testing.assert_allclose(ks.condition_number(big), 2.0, rtol=1e-12)
        np.testing.assert_allclose(ks.isotropy(big), 4 ** (1 / 3) / 2, rtol=1e-12)
        assert ks.manipulability(big) in (0.0, np.inf)
        np.testing.assert_allclose(ks.force_ellipsoid(big).radii * size, [0.5, 1, 1], rtol=1e-12)
    assert ks.condition_number(np.zeros((2, 2))) == np.inf
    assert ks.inverse_condition(np.zeros((2, 2))) == ks.isotropy(np.zeros((2, 2))) == 0


def test_singular_posture_is_flat_and_unbounded():
    """A stretched planar arm: no velocity along itself, and any force that way for nothing."""
    J = ks.jacobian(PLANAR, [0.6, 0.0])
    along, across = np.array([np.cos(0.6), np.sin(0.6)]), np.array([-np.sin(0.6), np.cos(0.6)])
    e, f = ks.velocity_ellipsoid(J), ks.force_ellipsoid(J)
    assert (e.is_flat, e.is_bounded, e.volume) == (True, True, 0.0)
    assert (f.is_flat, f.is_bounded, f.volume) == (False, False, np.inf)
    np.testing.assert_allclose(e.radii, [np.sqrt(5), 0.0])
    assert (e.extent(along), e.support(along)) == (0.0, 0.0)
    assert (f.extent(along), f.support(along)) == (np.inf, np.inf)
    np.testing.assert_allclose([e.extent(across), f.support(across)], [np.sqrt(5), 1 / np.sqrt(5)])
    assert e.extent([1.0, 0.0]) == 0.0
    np.testing.assert_allclose(f.extent([1.0, 0.0]), 1 / np.linalg.norm(J.array[0]))
    assert f.contains(1e9 * along)
    assert not e.contains(1e-6 * along)
    assert e.contains(2.2 * across)


def test_fewer_joints_than_rows():
    """Two joints in space: a flat disc, whatever the posture."""
    e = ks.velocity_ellipsoid(ks.jacobian(PLANAR, [0.3, 0.8]).linear)
    assert e.is_flat
    np.testing.assert_allclose(e.volume, 0.0)
    np.testing.assert_allclose(np.abs(e.axes[:, 2]), [0, 0, 1], atol=1e-15)
    assert e.extent([0.0, 0.0, 1.0]) == 0


def test_volumes():
    """Area and volume of ellipses with radii 3, 2 and 3, 2, 1, and of a segment."""
    assert ks.velocity_ellipsoid(np.diag([3.0, 2.0])).volume == pytest.approx(6 * np.pi)
    assert ks.velocity_ellipsoid(np.diag([3.0, 2.0, 1.0])).volume == pytest.approx(8 * np.pi)
    assert ks.velocity_ellipsoid([[3.0, 4.0]]).volume == pytest.approx(10.0)


def test_drawings_lie_on_the_surface():
    """Every point at distance one in the metric of the ellipsoid; curves and meshes close; clipped where asked."""
    J = ks.jacobian(PUMA, QN)
    e = ks.velocity_ellipsoid(J, task="position")
    X, Y, Z = e.points(20)
    np.testing.assert_array_equal(X[:, 0], X[:, -1])
    surface = np.stack([X, Y, Z], axis=-1).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(surface @ e.axes / e.radii, axis=-1), 1.0, rtol=1e-12)
    assert np.all(e.contains(surface))
    curve = ks.velocity_ellipsoid(ks.jacobian(PLANAR, [0.3, 0.8])).points(33)
    np.testing.assert_array_equal(curve[0], curve[-1])
    rates = curve @ np.linalg.inv(ks.jacobian(PLANAR, [0.3, 0.8]).array[:2]).T
    np.testing.assert_allclose(np.linalg.norm(rates, axis=-1), 1.0, rtol=1e-12)
    free = ks.force_ellipsoid(ks.jacobian(PLANAR, [0.6, 0.0]))
    assert np.abs(free.points(101, clip=3.0)).max() == pytest.approx(3 * np.cos(0.6), rel=1e-2)
    assert np.linalg.norm(e.points(9, clip=0.3), axis=0).max() <= 0.3 + 1e-12


def test_text_and_json():
    """One ellipsoid is a table, a batch a line; JSON holds plain data, with null for what is infinite."""
    f = ks.force_ellipsoid(ks.jacobian(PLANAR, [0.0, 0.0]))
    assert str(f).splitlines() == [
        "force ellipsoid of tip: axes of base, at the origin of tip",
        "radii [N] at unit joint torques, and their directions",
        "   radius  fx  fy",
        "   0.4472   0   1",
        "unbounded  -1   0",
    ]
    d = json.loads(json.dumps(f.to_dict(), allow_nan=False))
    assert d["radii"] == [pytest.approx(1 / np.sqrt(5)), None]
    assert (d["kind"], d["rows"], d["unit"], d["bounded"], d["volume"]) == ("force", ["fx", "fy"], "N", False, None)
    assert d["frame"] == {"axes": "base", "origin": "tip", "offset": [0.0, 0.0, 0.0]}
    six = ks.velocity_ellipsoid(ks.jacobian(PUMA, QN), length=0.5)
    assert six.rows == ("vx", "vy", "vz", "wx", "wy", "wz")
    assert "compared by L = 0.5 m" in str(six)
    assert max(map(len, str(six).splitlines())) <= 80
    batch = ks.velocity_ellipsoid(ks.jacobian(PUMA, np.stack([QN, QN])), task="orientation", joint_scale=np.full(6, 3.0))
    assert str(batch).splitlines()[1:] == [
        "radii [rad/s] at joint speeds within their scale, and their directions",
        "batch of shape (2,)",
    ]
    assert repr(batch) == "<Ellipsoid of velocity, radii of shape (2, 3)>"
    json.dumps(batch.to_dict(), allow_nan=False)
    bare = ks.velocity_ellipsoid([[2.0, 0.0], [0.0, 0.0]])
    assert (bare.rows, bare.unit, bare.frame, bare.link) == ((), "", None, "")
    assert str(bare).splitlines()[-1].split() == ["flat", "0", "1"]
    with pytest.raises(AttributeError):
        bare.kind = "force"


J = ks.jacobian(PUMA, QN)
DISC = ks.velocity_ellipsoid([[2.0, 0.0], [0.0, 1.0]])
SYMBOLS = np.array([[sp.Symbol("x"), 0, 0], [0, 1, 0], [0, 0, 1]])
MISTAKES = {
    "metres and radians": (lambda: ks.condition_number(J), r"KS360.*vx, vy, vz, wx, wy, wz.*\n.*characteristic_length"),
    "metres and radians, ellipsoid": (lambda: ks.velocity_ellipsoid(J), "KS360"),
    "metres and radians, asada": (lambda: ks.asada(J, np.eye(6)), "KS360"),
    "metres and radians, gradient": (lambda: ks.manipulability_gradient(PUMA, QN, measure="isotropy"), "KS360"),
    "task of a bare array": (lambda: ks.manipulability(J.linear, task="position"), "KS361.*task="),
    "length of a bare array": (lambda: ks.isotropy(J.array, length=1.0), "KS361.*length="),
    "others of a bare array": (lambda: ks.asada(J.linear, np.eye(6), others="held"), "KS361.*others="),
    "no length": (lambda: ks.isotropy(J, length=0.0), "KS303.*length"),
    "length as text": (lambda: ks.isotropy(J, length="long"), "KS303.*length"),
    "a row that is none": (lambda: ks.manipulability(J, task="vw"), "KS318"),
    "a vector": (lambda: ks.manipulability([1.0, 2.0]), "KS303"),
    "a twist": (lambda: ks.manipulability(ks.Twist.of((0, 0, 1))), "KS302.*Twist"),
    "a Hessian": (lambda: ks.manipulability(ks.hessian(PUMA, QN)), "KS302.*Hessian"),
    "text": (lambda: ks.manipulability("J"), "KS302"),
    "three of symbols": (lambda: ks.condition_number(SYMBOLS), "KS302.*closed form"),
    "ellipsoid of symbols": (lambda: ks.velocity_ellipsoid(SYMBOLS), "KS302"),
    "asada of symbols": (lambda: ks.asada(SYMBOLS, np.eye(3)), "KS302"),
    "gradient of symbols": (lambda: ks.manipulability_gradient(PLANAR, THETA[:2]), r"KS302.*\n.*diff"),
    "unknown measure": (lambda: ks.manipulability_gradient(PUMA, QN, measure="isotropic"), r"KS365.*\n.*isotropy"),
    "unknown others": (lambda: ks.asada(J.linear, np.eye(6), others="still"), "KS365"),
    "mass matrix of another size": (lambda: ks.asada(J.linear, np.eye(3)), "KS303.*mass matrix"),
    "mass matrix not symmetric": (lambda: ks.asada(J.linear, np.triu(np.ones((6, 6)))), "KS303.*symmetric"),
    "mass matrix not positive": (lambda: ks.asada(J.linear, np.zeros((6, 6))), "KS303.*positive"),
    "mass matrix NaN": (lambda: ks.asada(J.linear, np.full((6, 6), np.nan)), "KS301"),
    "batches": (lambda: ks.asada(np.ones((2, 3, 6)), np.stack([np.eye(6)] * 3)), r"KS303.*\(2,\).*\(3,\)"),
    "libraries": (lambda: ks.asada(J.linear, torch.eye(6)), "KS302.*torch"),
    "scale of another size": (lambda: ks.velocity_ellipsoid(J.linear, joint_scale=[1.0, 2.0]), "KS362"),
    "unknown limits": (lambda: ks.velocity_ellipsoid(J.linear, joint_scale=np.full(6, np.inf)), "KS362.*infinite"),
    "scale of zero": (lambda: ks.force_ellipsoid(J.linear, joint_scale=np.zeros(6)), "KS362"),
    "scale as text": (lambda: ks.force_ellipsoid(J.linear, joint_scale="many"), "KS362"),
    "scale as a number": (lambda: ks.force_ellipsoid(J.linear, joint_scale=3.0), "KS362"),
    "scale of another batch": (
        lambda: ks.force_ellipsoid(np.ones((2, 3, 6)), joint_scale=np.ones((3, 6))),
        "KS303.*joint_scale",
    ),
    "drawn without end": (lambda: ks.force_ellipsoid(np.diag([1.0, 0.0])).points(), r"KS363.*\n.*clip"),
    "drawn in six dimensions": (lambda: ks.velocity_ellipsoid(J, length=1.0).points(), "KS364.*6 rows"),
    "clip of zero": (lambda: DISC.points(clip=0.0), "KS303.*clip"),
    "no points": (lambda: DISC.points(1), "KS303.*count"),
    "half a point": (lambda: DISC.points(8.5), "KS303.*count"),
    "direction of no length": (lambda: DISC.support([0.0, 0.0]), "KS303.*length"),
    "direction of another size": (lambda: DISC.extent([0.0, 0.0, 1.0]), "KS303.*shape"),
    "direction NaN": (lambda: DISC.extent([0.0, np.nan]), "KS301"),
    "points of another size": (lambda: DISC.contains([[1.0, 2.0, 3.0]]), "KS303.*points"),
    "points as text": (lambda: DISC.contains("here"), "KS302"),
}


@pytest.mark.parametrize("mistake", MISTAKES, ids=lambda name: name.replace(" ", "_"))
def test_a_mistake_is_named(mistake):
    """Code, place and remedy."""
    call, pattern = MISTAKES[mistake]
    with pytest.raises(ks.KinestaticsError, match=f"(?s){pattern}"):
        call()
