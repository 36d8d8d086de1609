"""Ellipsoids are images and duals of the unit ball, measures belong to it and not to its axes, gradients are derivatives."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import kinestatics as ks
from strategies import assert_close, features

MEASURES = ("manipulability", "smallest_singular_value", "inverse_condition", "isotropy")
ARMS = ("planar_2r", "planar_3r", "scara", "elbow_rrr", "stanford_arm", "rrp_note_001", "al5d", "puma_560", "ur5e", "panda")
STEP = 1e-5


@st.composite
def matrices(draw):
    """Rows (r, n) of every shape, some of lower rank, with a generator for directions."""
    rng = np.random.default_rng(draw(st.integers(0, 2**31 - 1)))
    r, n = draw(st.integers(1, 6)), draw(st.integers(0, 8))
    rank = draw(st.integers(0, min(r, n)))
    rows = rng.normal(size=(r, rank)) @ rng.normal(size=(rank, n)) * 10.0 ** draw(st.integers(-3, 3))
    return rows, rng


def rotation(rng, k):
    """A random rotation matrix of k dimensions."""
    Q, R = np.linalg.qr(rng.normal(size=(k, k)))
    Q = Q * np.sign(np.diag(R))
    Q[:, 0] *= np.linalg.det(Q)
    return Q


def unit(rng, *shape):
    """Random unit vectors along the last axis."""
    v = rng.normal(size=shape)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@given(matrices())
def test_the_two_ellipsoids_are_dual(drawn):
    """Same axes, reciprocal radii; the extent of one along a direction is the reciprocal of the other's support."""
    rows, rng = drawn
    velocity, force = ks.velocity_ellipsoid(rows), ks.force_ellipsoid(rows)
    np.testing.assert_array_equal(velocity.axes, force.axes)
    regular = velocity.radii > 0
    np.testing.assert_allclose((velocity.radii * np.where(regular, force.radii, 1.0))[regular], 1.0, rtol=1e-14)
    assert np.all(np.isinf(force.radii[~regular]))
    assert velocity.is_flat == (not force.is_bounded) == bool(np.any(~regular))
    directions = unit(rng, 20, len(rows))
    assert_reciprocal(velocity.support(directions), force.extent(directions))
    assert_reciprocal(velocity.extent(directions), force.support(directions))
    for axis, radius in zip(velocity.axes.T, velocity.radii, strict=True):
        np.testing.assert_allclose([velocity.support(axis), velocity.extent(axis)], radius, rtol=1e-12)


def assert_reciprocal(a, b):
    """The products are 1, or one is 0 where the other is infinite."""
    finite = np.isfinite(a) & np.isfinite(b)
    np.testing.assert_allclose(a[finite] * b[finite], 1.0, rtol=1e-12)
    np.testing.assert_array_equal(a[~finite] == 0, np.isinf(b[~finite]))
    np.testing.assert_array_equal(np.isinf(a[~finite]), b[~finite] == 0)


@given(matrices())
def test_support_and_extent_are_what_the_rows_say(drawn):
    """Velocity support = |Jᵀ d|, force extent = 1/|Jᵀ d|; velocity extent = 1/√(dᵀ (J Jᵀ)⁻¹ d) where J has full row rank."""
    rows, rng = drawn
    d = unit(rng, 20, len(rows))
    felt = np.linalg.norm(d @ rows, axis=-1)
    scale = max(1e-300, np.abs(rows).max(initial=0.0))
    np.testing.assert_allclose(ks.velocity_ellipsoid(rows).support(d), felt, rtol=1e-12, atol=1e-9 * scale)
    if np.all(felt > 1e-6 * scale):
        np.testing.assert_allclose(ks.force_ellipsoid(rows).extent(d), 1 / felt, rtol=1e-9)
    sigma = np.linalg.svd(rows, compute_uv=False)
    if rows.shape[1] >= len(rows) and sigma[-1] > 1e-3 * sigma[0]:
        needed = np.linalg.norm(d @ np.linalg.pinv(rows).T, axis=-1)
        np.testing.assert_allclose(ks.velocity_ellipsoid(rows).extent(d), 1 / needed, rtol=1e-9)


@given(matrices())
def test_the_velocity_ellipsoid_is_the_image_of_the_unit_ball(drawn):
    """Every image lies in it; every point of its surface needs joint speeds of size one, and a larger one needs more."""
    rows, rng = drawn
    r, n = rows.shape
    e = ks.velocity_ellipsoid(rows)
    assert np.all(e.contains((unit(rng, 200, n) * rng.random((200, 1))) @ rows.T))
    assert e.contains(np.zeros(r))
    surface = unit(rng, 50, r) * e.radii @ e.axes.T
    scale = np.linalg.norm(surface, axis=-1, keepdims=True)
    if np.all(scale > 0.1 * e.radii[0]) and e.radii[0] > 0:
        assert np.all(e.contains(surface))
        if not e.is_flat and e.radii[-1] > 1e-3 * e.radii[0]:
            assert not np.any(e.contains(surface * (1 + 1e-6)))
            needed = np.linalg.norm(surface @ np.linalg.pinv(rows).T, axis=-1)
            np.testing.assert_allclose(needed, 1.0, rtol=1e-9)
    if e.is_flat and e.radii[0] > 0:
        assert not e.contains(1e-3 * e.radii[0] * e.axes[:, -1])


@given(matrices())
def test_the_force_ellipsoid_holds_with_unit_torques(drawn):
    """w lies in it exactly if the joints feel |Jᵀ w| <= 1; what no joint feels may be as large as it likes."""
    rows, rng = drawn
    e = ks.force_ellipsoid(rows)
    w = rng.normal(size=(100, len(rows))) / max(1e-300, np.abs(rows).max(initial=0.0))
    felt = np.linalg.norm(w @ rows, axis=-1)
    clear = np.abs(felt - 1) > 1e-6
    np.testing.assert_array_equal(e.contains(w)[clear], felt[clear] < 1)
    free = e.axes[:, np.isinf(e.radii)]
    assert np.all(e.contains(1e6 * free.T)) or not free.size
    assert np.abs(free.T @ rows).max(initial=0.0) <= 1e-9 * np.abs(rows).max(initial=0.0)


@given(matrices())
def test_axes_turn_with_the_rows(drawn):
    """Rows turned by R: the same radii, support and extent turned with them; axes are rotation matrices of fixed sign."""
    rows, rng = drawn
    k = len(rows)
    R, d = rotation(rng, k), unit(rng, 10, k)
    e, turned = ks.velocity_ellipsoid(rows), ks.velocity_ellipsoid(R @ rows)
    scale = np.abs(rows).max(initial=0.0)
    np.testing.assert_allclose(turned.radii, e.radii, rtol=1e-9, atol=1e-12 * scale)
    np.testing.assert_allclose(turned.support(d @ R.T), e.support(d), rtol=1e-9, atol=1e-12 * scale)
    for made in (e, turned):
        np.testing.assert_allclose(made.axes.T @ made.axes, np.eye(k), atol=1e-13)
        np.testing.assert_allclose(np.linalg.det(made.axes), 1.0, rtol=1e-12)
        for axis in made.axes.T[:-1]:
            assert axis[np.argmax(np.abs(axis) > 0.5 * np.abs(axis).max())] > 0
    moving = (e.radii > 1e-6 * e.radii[0]) & (np.arange(k) < k - 1)  # the last is turned to suit the others
    np.testing.assert_allclose(ks.velocity_ellipsoid(-rows).axes[:, moving], e.axes[:, moving], atol=1e-9)


@given(matrices())
def test_measures_are_functions_of_the_singular_values(drawn):
    """Volume, determinant, condition, and the means: each against its own definition."""
    rows, rng = drawn
    r, n = rows.shape
    k = min(r, n)
    sigma = ks.singular_values(rows)
    assert sigma.shape == (k,)
    w = ks.manipulability(rows)
    if not k:
        assert (w, ks.isotropy(rows), ks.inverse_condition(rows), ks.condition_number(rows)) == (0, 0, 0, np.inf)
        return
    scale = max(sigma[0], 1e-300)
    gram = rows @ rows.T if r <= n else rows.T @ rows
    np.testing.assert_allclose(w**2, np.linalg.det(gram), rtol=1e-6, atol=1e-9 * scale ** (2 * k))
    ratio = ks.inverse_condition(rows)
    assert ratio == (sigma[-1] / sigma[0] if sigma[-1] > 1e-10 * sigma[0] else 0)
    assert ks.condition_number(rows) == (1 / ratio if ratio else np.inf)
    assert ks.smallest_singular_value(rows) == sigma[-1]
    if sigma[0] > 0:
        expected = np.exp(np.mean(2 * np.log(np.maximum(sigma, 1e-300)))) / np.mean(sigma**2)
        np.testing.assert_allclose(ks.isotropy(rows), expected, rtol=1e-9, atol=1e-12)
    for name in (*MEASURES, "condition_number"):
        turned = getattr(ks, name)(rotation(rng, r) @ rows @ rotation(rng, n))
        if sigma[-1] > 1e-6 * sigma[0] or name in ("manipulability", "smallest_singular_value"):
            size = scale ** (k if name == "manipulability" else 1)
            np.testing.assert_allclose(turned, getattr(ks, name)(rows), rtol=1e-7, atol=1e-12 * size)


@given(features(max_joints=7))
def test_measures_do_not_depend_on_the_axes_of_the_frame(f):
    """Base axes or tip axes at the same point: the rows in play may differ, the measures do not."""
    model = f.model()
    q = f.configurations(3)
    in_base, in_tip = ks.jacobian(model, q), ks.jacobian(model, q, frame=ks.Frame.body())
    length = ks.characteristic_length(model)
    for name in (*MEASURES, "condition_number"):
        for J, other in ((in_base, in_tip), (in_tip, in_base.change_frame(ks.Frame.body()))):
            a, b = (getattr(ks, name)(matrix, length=length) for matrix in (J, other))
            assert a.shape == (3,)
            sigma = ks.singular_values(J, length=length).max(initial=0.0)
            regular = ks.inverse_condition(J, length=length) > 1e-5
            power = 6 if name == "manipulability" else 1
            np.testing.assert_allclose(a[regular], b[regular], rtol=1e-8, atol=1e-10 * max(1.0, sigma) ** power)
    e, b = (ks.force_ellipsoid(J, length=length) for J in (in_base, in_tip))
    finite = [np.where(np.isinf(x.radii), 0.0, x.radii).max(-1, initial=0.0) for x in (e, b)]
    regular = ks.inverse_condition(in_base, length=length) > 1e-5
    np.testing.assert_allclose(finite[0][regular], finite[1][regular], rtol=1e-8)


@given(features(max_joints=6, tree=False))
def test_the_gradient_is_the_derivative(f):
    """∂w/∂q by central differences, for every mechanism, frame of the tip, and choice of rows."""
    model = f.model()
    if not model.n:
        return
    q = f.configurations(2)
    for task in ("auto", "position"):
        for frame in (None, ks.Frame.body()):
            found = ks.manipulability_gradient(model, q, task=task, frame=frame)
            assert found.shape == q.shape
            slope = differences(lambda x: ks.manipulability(ks.jacobian(model, x, frame=frame), task=task), q)  # noqa: B023
            scale = max(1.0, np.abs(ks.jacobian(model, q).array).max()) ** 6
            w = ks.manipulability(ks.jacobian(model, q, frame=frame), task=task)
            regular = w > 1e-3 * scale ** (1 / 3)
            assert np.abs(found - slope)[regular].max(initial=0.0) <= 1e-6 * scale


def differences(function, q):
    """Central differences of a scalar function by every joint."""
    steps = STEP * np.eye(q.shape[-1])
    return np.stack([(function(q + step) - function(q - step)) / (2 * STEP) for step in steps], axis=-1)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("name", ARMS)
def test_gradients_of_real_arms(name, measure):
    """All four measures, in a batch, against central differences."""
    arm = ks.load(name)
    length = ks.characteristic_length(arm)
    q = arm.random_configurations(4, seed=3)

    def value(x):
        return getattr(ks, measure)(ks.jacobian(arm, x), length=length)

    found = ks.manipulability_gradient(arm, q, measure=measure, length=length)
    np.testing.assert_allclose(found, differences(value, q), rtol=1e-6, atol=1e-8)
    np.testing.assert_allclose(
        found, [ks.manipulability_gradient(arm, x, measure=measure, length=length) for x in q], atol=1e-14
    )


@pytest.mark.parametrize(
    ("name", "q", "options"),
    [
        ("planar_2r", [0.4, 0.0], {}),
        ("planar_3r", [0.4, 0.0, 0.0], {"task": "position"}),
        ("puma_560", [0.1, 0.4, -1.0, 0.3, 0.0, 0.2], {"length": 0.9}),
        ("iiwa_14", [0.3, 0.5, 0.2, 0.0, 0.7, 1.1, 0.1], {"length": 1.0}),
    ],
)
@pytest.mark.parametrize("measure", ["manipulability", "smallest_singular_value", "inverse_condition"])
def test_at_a_singularity_it_is_the_steepest_ascent(name, q, options, measure):
    """The measure grows at the rate |g| along g and along -g, and no faster in any other direction."""
    arm, q = ks.load(name), np.array(q)

    def value(x):
        return getattr(ks, measure)(ks.jacobian(arm, x), **options)

    assert value(q) <= 1e-12
    g = ks.manipulability_gradient(arm, q, measure=measure, **options)
    slope, step = np.linalg.norm(g), 1e-6
    assert slope > 1e-3
    for sign in (1, -1):
        np.testing.assert_allclose(value(q + sign * step * g / slope) / step, slope, rtol=1e-4)
    directions = unit(np.random.default_rng(0), 300, arm.n)
    assert np.all(value(q + step * directions) / step <= slope * (1 + 1e-4))
    assert g[np.argmax(np.abs(g) > 0.5 * np.abs(g).max())] > 0


@pytest.mark.parametrize("name", ARMS)
def test_the_unit_of_length_changes_no_condition(name):
    """An arm described in millimetres has the same condition, isotropy and shape, with the length that goes with it."""
    arm = ks.load(name)
    scaled = in_other_units(arm, 1000.0)
    q = arm.random_configurations(3, seed=5)
    other = q * np.where(np.array(arm.joint_kinds) == "prismatic", 1000.0, 1.0)
    J, K = ks.jacobian(arm, q), ks.jacobian(scaled, other, check_finite=False)
    length = ks.characteristic_length(arm)
    for measure in ("condition_number", "inverse_condition", "isotropy"):
        a, b = getattr(ks, measure)(J, length=length), getattr(ks, measure)(K, length=1000.0 * length)
        np.testing.assert_allclose(a, b, rtol=1e-9)
    e, f = ks.velocity_ellipsoid(J, length=length), ks.velocity_ellipsoid(K, length=1000.0 * length)
    np.testing.assert_allclose(f.radii, 1000.0 * e.radii, rtol=1e-9)


def in_other_units(model, factor):
    """The model with all lengths multiplied."""
    from dataclasses import replace

    prismatic = np.array(model.kinds) == "prismatic"
    placements, links, screws = model.placements.copy(), model.link_placements.copy(), model.screws.copy()
    placements[:, :3, 3] *= factor
    links[:, :3, 3] *= factor
    screws[~prismatic, :3] *= factor
    offsets = model.offsets * np.where(prismatic, factor, 1.0)
    by_column = np.where(np.array(model.joint_kinds) == "prismatic", factor, 1.0)
    limits = {word: getattr(model, word) * by_column for word in ("lower", "upper", "home")}
    return replace(model, placements=placements, link_placements=links, screws=screws, offsets=offsets, **limits)


@given(matrices())
def test_scales_of_joints_keep_the_duality(drawn):
    """force_ellipsoid(J, joint_scale=1/s) is dual to velocity_ellipsoid(J, joint_scale=s): speeds within s."""
    rows, rng = drawn
    n = rows.shape[1]
    s = 10.0 ** rng.uniform(-1, 1, n)
    velocity, force = ks.velocity_ellipsoid(rows, joint_scale=s), ks.force_ellipsoid(rows, joint_scale=1 / s)
    d = unit(rng, 10, len(rows))
    assert_reciprocal(velocity.support(d), force.extent(d))
    assert np.all(velocity.contains(unit(rng, 100, n) * s @ rows.T))
    assert_close(velocity.radii[: min(rows.shape)], np.linalg.svd(rows * s, compute_uv=False), 1e-9)


@given(features(max_joints=6))
def test_asada_is_the_roundness_of_the_inertia_felt(f):
    """λmin/λmax of (J M⁻¹ Jᵀ)⁻¹; free rows lighter than held ones; M = 1 gives the condition squared."""
    model = f.model()
    q, rng = f.configurations(2), np.random.default_rng(f.seed)
    if model.n < 3:
        return
    half = rng.normal(size=(2, model.n, model.n))
    M = half @ half.swapaxes(-1, -2) + 0.1 * np.eye(model.n)
    J = ks.jacobian(model, q)
    np.testing.assert_allclose(ks.asada(J.linear, np.eye(model.n)), ks.inverse_condition(J.linear) ** 2, atol=1e-9)
    mobility = J.linear @ np.linalg.inv(M) @ J.linear.swapaxes(-1, -2)
    eigenvalues = np.linalg.eigvalsh(mobility)
    expected = eigenvalues[..., 0] / np.maximum(eigenvalues[..., -1], 1e-300)
    np.testing.assert_allclose(ks.asada(J.linear, M), np.maximum(expected, 0.0), atol=1e-9)
    full = ks.find_task(model)
    if full.rank == 6:
        Lambda = np.linalg.inv(J.array @ np.linalg.inv(M) @ J.array.swapaxes(-1, -2))
        block = np.linalg.eigvalsh(Lambda[..., :3, :3])
        held = ks.asada(J, M, task="position", others="held")
        regular = ks.inverse_condition(J, length=1.0) > 1e-3
        np.testing.assert_allclose(held[regular], (block[..., 0] / block[..., -1])[regular], rtol=1e-5)
        with_length = ks.asada(J, M, length=1.0)
        np.testing.assert_allclose(ks.asada(J, M, length=1.0, others="held"), with_length, rtol=1e-12)
