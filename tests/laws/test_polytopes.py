"""Polytopes hold exactly what the limits of the joints allow, and their surfaces are those of convex bodies.

The judge is scipy's linear programming (HiGHS): a velocity can be had when some rates within the limits give it.
"""

from itertools import combinations

import numpy as np
from hypothesis import example, given, strategies as st
from scipy.optimize import linprog

import kinestatics as ks
from kinestatics.dexterity.shapes import image_of_box, let_through
from kinestatics.tasks import without_rounding
from strategies import Features, assert_close, features, random_rotation

TASKS = st.sampled_from(["position", "orientation", "vx,vy", "vz", "vx,wy", "full", "vx,vy,wz"])
NEAR = 1e-6  # a step off a facet, as a share of the size of the set: far more than rounding, far less than a facet


def drawn(f, task):
    """A mechanism, a configuration, uneven limits both ways, and the bare rows of a task; None where nothing moves."""
    model = f.model()
    if model.n == 0:
        return None
    rng = np.random.default_rng(f.seed)
    q = f.configurations()
    lower, upper = -rng.uniform(0.2, 2.0, model.n), rng.uniform(0.2, 2.0, model.n)
    J = without_rounding(model, ks.jacobian(model, q).array)[list(ks.find_task(model, task).rows)]
    return model, q, lower, upper, J, rng


def can_be_had(J, v, lower, upper):
    """Whether some rates within the limits give the velocity."""
    return linprog(np.zeros(J.shape[1]), A_eq=J, b_eq=v, bounds=list(zip(lower, upper, strict=True))).status == 0


def greatest(c, A, b):
    """max c · x with A x <= b: a number, inf, or None where nothing obeys the rows."""
    found = linprog(-c, A_ub=A, b_ub=b, bounds=(None, None))
    if found.status == 4 or (found.status == 2 and linprog(0 * c, A_ub=A, b_ub=b, bounds=(None, None)).status == 0):
        return np.inf  # "infeasible or unbounded", and it is feasible
    return {0: lambda: -found.fun, 3: lambda: np.inf, 2: lambda: None}[found.status]()


@given(features(max_joints=6), TASKS)
def test_every_rate_maps_inside_and_no_step_off_a_facet_can_be_had(f, task):
    """{J q̇} is the velocity polytope: sampled rates map inside; beyond a facet the judge finds no rates, before it some."""
    if (found := drawn(f, task)) is None:
        return
    model, q, lower, upper, J, rng = found
    p = ks.velocity_polytope(model, q, task=task, velocity_limits=(lower, upper))
    rates = rng.uniform(lower, upper, (200, model.n))
    corners_of_box = np.where(rng.random((200, model.n)) < 0.5, lower, upper)
    assert np.all(p.contains(np.vstack([rates, corners_of_box]) @ J.T))
    for i in rng.permutation(len(p.offsets))[:5]:
        state = p.states[i]
        on_facet = J @ np.where(state > 0, upper, np.where(state < 0, lower, 0.5 * (lower + upper)))
        size = np.abs(p.generators).sum()
        if np.any(state) and size > 1e-3:  # facets of lost directions have no joint
            outside = on_facet + NEAR * size * p.normals[i]
            assert not p.contains(outside)
            assert not can_be_had(J / size, outside / size, lower, upper)
            assert can_be_had(J / size, (on_facet + NEAR * (p.center - on_facet)) / size, lower, upper)


@given(features(max_joints=7), TASKS)
def test_a_push_is_inside_exactly_when_no_joint_passes_its_limit(f, task):
    """f is in the force polytope if and only if l <= Jᵀ f + τ_gravity <= u."""
    if (found := drawn(f, task)) is None or not found[0].has_masses:
        return
    model, q, lower, upper, J, rng = found
    held = ks.gravity_torques(model, q)
    lower, upper = lower + held, upper + held
    lower[0] -= 2.5 * (f.seed % 2)  # the weight is not in the middle
    p = ks.force_polytope(model, q, task=task, effort_limits=(lower, upper))
    scale = 2.0 / np.maximum(np.linalg.norm(J, axis=1), 1e-3)
    pushes = rng.normal(size=(500, len(J))) * scale * rng.uniform(0, 1.5, (500, 1))
    torques = pushes @ J + held
    slack = np.minimum(torques - lower, upper - torques).min(axis=1)
    clear = np.abs(slack) > 1e-6 * (1 + np.abs(pushes).max(axis=1))
    assert np.array_equal(p.contains(pushes)[clear], (slack > 0)[clear])


@given(features(max_joints=7), st.sampled_from(["position", "orientation", "vx,vy,wz"]))
def test_surfaces_in_space_are_closed(f, task):
    """V - E + F = 2; every edge is walked once each way; polygons lie in their facets; normals point outwards."""
    if (found := drawn(f, task)) is None:
        return
    model, q, lower, upper, *_ = found
    for p in (
        ks.velocity_polytope(model, q, task=task, velocity_limits=(lower, upper)),
        ks.force_polytope(model, q, task=task, effort_limits=(lower, upper), gravity=None),
    ):
        assert p.is_empty is False
        if p.is_flat or not p.is_bounded:
            continue
        assert len(p.faces) == len(p.offsets)
        edges = [edge for face in p.faces for edge in zip(face, (*face[1:], face[0]), strict=True)]
        assert len(set(edges)) == len(edges)
        assert {(b, a) for a, b in edges} == set(edges)
        assert len(p.vertices) - len(edges) // 2 + len(p.faces) == 2
        size = np.abs(p.vertices - p.center).max()
        for face, normal, offset in zip(p.faces, p.normals, p.offsets, strict=True):
            assert np.abs(p.vertices[list(face)] @ normal - offset).max() <= 1e-8 * size
        assert p.volume > 0
        sigma = np.linalg.svd(p.vertices - p.vertices.mean(axis=0), compute_uv=False)
        assert abs(p.volume / hull_volume(p) - 1) <= 1e-9 + 1e-14 * sigma[0] / sigma[-1]


def hull_volume(p):
    """The volume as pyramids from the middle to the polygons, in coordinates in which the body is about as thick as long."""
    spread = p.vertices - p.vertices.mean(axis=0)
    _, sigma, Vt = np.linalg.svd(spread, full_matrices=False)
    corners, total = spread @ Vt.T / sigma, 0.0
    for face in p.faces:
        polygon = corners[list(face)]
        normal = np.cross(polygon[1:-1] - polygon[0], polygon[2:] - polygon[0]).sum(axis=0)
        total += abs(normal @ polygon.mean(axis=0)) / 6.0
    return total * np.prod(sigma)


@given(features(max_joints=7), TASKS)
@example(Features(seed=1173, joints=5, mimic=True, right_angles=True, other_base=True), "vx,wy")  # 1e-10 as thin as long
def test_corners_are_extreme_and_can_be_had(f, task):
    """At every corner the facets through it leave no direction free; corners obey the limits."""
    if (found := drawn(f, task)) is None:
        return
    model, q, lower, upper, J, _ = found
    velocities = ks.velocity_polytope(model, q, task=task, velocity_limits=(lower, upper))
    forces = ks.force_polytope(model, q, task=task, effort_limits=(lower, upper), gravity=None)
    for p in (velocities, forces):
        if p.corners is None:
            assert len(p.rows) > 3
            continue
        size = max(p.size, float(np.abs(p.corners).max()))
        heights = p.corners @ p.normals.T
        assert np.all(heights <= p.offsets + 1e-8 * np.ptp(heights, axis=0) + 1e-10 * size)
        if p.is_bounded and p.dimension:
            spread = p.corners - p.corners.mean(axis=0)
            _, sigma, Vt = np.linalg.svd(spread, full_matrices=False)
            round_normals = p.normals @ (Vt.T * sigma)[:, : p.dimension]  # a set may be very thin
            lengths = np.linalg.norm(round_normals, axis=1)
            faces = np.any(p.states != 0, axis=1)  # not the planes of a flat set
            round_normals = round_normals[faces] / lengths[faces, None]
            on = p.offsets - heights <= 1e-8 * np.ptp(heights, axis=0) + 1e-14 * size
            assert all(np.linalg.matrix_rank(round_normals[row], tol=1e-11) == p.dimension for row in on[:, faces])
    if forces.corners is not None:
        torques = forces.corners @ J
        rounding = 1e-9 + 1e-14 * np.abs(forces.corners).max()  # of forces that are very large near a singularity
        assert np.all((torques >= lower - rounding) & (torques <= upper + rounding))


@given(features(max_joints=7), TASKS)
def test_virtual_work_joins_the_two(f, task):
    """The greatest power of a push is Σ |τ_i| times the speed limit: h_velocity(f) = Σ l_i |J_iᵀ f|.

    And the force polytope is the polar set of the hull of ±J_i / t_i: its extent is the reciprocal of that hull's support.
    """
    if (found := drawn(f, task)) is None:
        return
    model, q, _, upper, J, rng = found
    velocities = ks.velocity_polytope(model, q, task=task, velocity_limits=upper)
    forces = ks.force_polytope(model, q, task=task, effort_limits=upper, gravity=None)
    pushes = rng.normal(size=(20, len(J)))
    power = np.abs(pushes @ J) @ upper
    assert np.abs(velocities.support(pushes) - power).max() <= 1e-12 * max(1.0, power.max())
    if velocities.corners is not None:
        assert np.abs((pushes @ velocities.corners.T).max(axis=1) - power).max() <= 1e-9 * max(1.0, power.max())
    units = pushes / np.linalg.norm(pushes, axis=1, keepdims=True)
    hull = np.abs(units @ J / upper).max(axis=1)
    clear = hull > 1e-6
    assert np.abs(forces.extent(pushes)[clear] * hull[clear] - 1).max(initial=0.0) <= 1e-9
    assert np.all(forces.limiting_facet(push) for push in pushes[clear])


@given(features(max_joints=6), st.booleans())
def test_turned_axes_turn_the_polytope(f, forces):
    """The same set in the axes of the tip and of the base: supports, extents and volume agree."""
    if (found := drawn(f, "position")) is None:
        return
    model, q, lower, upper, *_, rng = found
    body = ks.Frame.body()
    R = ks.pose(model, q).rotation
    if forces:
        here = ks.force_polytope(model, q, task="position", effort_limits=(lower, upper), gravity=None)
        there = ks.force_polytope(model, q, task="position", effort_limits=(lower, upper), gravity=None, frame=body)
    else:
        here = ks.velocity_polytope(model, q, task="position", velocity_limits=(lower, upper))
        there = ks.velocity_polytope(model, q, task="position", velocity_limits=(lower, upper), frame=body)
    assert (here.dimension, here.is_bounded, len(here.corners)) == (there.dimension, there.is_bounded, len(there.corners))
    d = rng.normal(size=(10, 3))
    for ask in ("support", "extent"):
        a, b = getattr(here, ask)(d), getattr(there, ask)(d @ R)
        assert np.array_equal(np.isinf(a), np.isinf(b))
        known = np.isfinite(a)
        assert np.abs(a[known] - b[known]).max(initial=0.0) <= 1e-7 * max(1.0, np.abs(a[known]).max(initial=0.0))


@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(1, 9), st.booleans())
@example(6, 5, 6, True)
def test_a_linear_map_maps_the_zonotope(seed, k, n, coarse):
    """Corners, and the volume 2^k Σ |det of k generators|, go with any change of coordinates, however uneven its units."""
    rng = np.random.default_rng(seed)
    J = rng.integers(-1, 2, (k, n)).astype(float) if coarse else rng.normal(size=(k, n))
    M = (
        random_rotation(rng, False)[:k, :k] * 10.0 ** rng.uniform(-3, 3, (k, 1))
        if k <= 3
        else np.diag(10.0 ** rng.uniform(-3, 3, k))
    )
    lower, upper = -rng.random(n), rng.random(n)
    names = {"kind": "velocity", "unit": "", "joints": tuple(map(str, range(n))), "rows": tuple(map(str, range(k)))}
    here = image_of_box(J, lower, upper, np.ones(k), **names)
    there = image_of_box(M @ J, lower, upper, np.ones(k), **names)
    assert here.dimension == there.dimension == np.linalg.matrix_rank(J)
    assert len(here.offsets) == len(there.offsets)
    if k > 3:
        return
    wanted, got = here.corners @ M.T, there.corners
    gaps = np.linalg.norm((wanted[:, None] - got) / np.linalg.norm(M, axis=1), axis=-1)
    assert max(gaps.min(0).max(), gaps.min(1).max()) <= 1e-9
    dets = sum(abs(np.linalg.det(here.generators[list(subset)])) for subset in combinations(range(n), k))
    assert abs(here.volume - 2**k * dets) <= 1e-9 * max(1.0, here.volume)
    assert abs(there.volume - abs(np.linalg.det(M)) * here.volume) <= 1e-9 * there.volume


@given(st.integers(0, 10**6), st.integers(1, 6), st.integers(1, 8), st.sampled_from(["both", "one side", "weak", "coarse"]))
def test_sets_of_half_spaces_are_what_the_judge_says(seed, k, n, sort):
    """Empty, unbounded, and the support in any direction: as linear programs say; corners, rays and free lines are in it."""
    rng = np.random.default_rng(seed)
    A = rng.integers(-1, 2, (n, k)).astype(float) if sort == "coarse" else rng.normal(size=(n, k))
    lower, upper = -rng.uniform(0.1, 1.0, n), rng.uniform(0.1, 1.0, n)
    if sort == "one side":
        lower = np.where(rng.random(n) < 0.6, -np.inf, lower)
        upper = np.where(rng.random(n) < 0.2, np.inf, upper)
    if sort == "weak":
        lower, upper = lower + 0.7, upper + 0.7
    names = {"kind": "force", "unit": "", "joints": tuple(map(str, range(n))), "rows": tuple(map(str, range(k)))}
    p = let_through(A, lower, upper, np.ones(k), **names)
    both = np.vstack([A, -A])
    limits = np.r_[upper, -lower]
    both, limits = both[np.isfinite(limits)], limits[np.isfinite(limits)]
    both, limits = np.vstack([both, np.zeros(k)]), np.r_[limits, 1.0]  # the judge wants at least one row
    d = rng.normal(size=(4, k))
    judged = [greatest(one, both, limits) for one in d]
    assert p.is_empty == (judged[0] is None)
    if p.is_empty:
        assert p.notes
        assert np.all(p.support(d) == -np.inf)
        assert np.all(p.extent(d) == -np.inf)
        assert not p.contains(np.zeros(k))
        return
    for found, wanted in zip(p.support(d), judged, strict=True):
        assert found == wanted if np.isinf(wanted) else abs(found - wanted) <= 1e-8 * max(1.0, abs(wanted))
    axes = [greatest(sign * axis, both, limits) for axis in np.eye(k) for sign in (1, -1)]
    assert p.is_bounded == bool(np.all(np.isfinite(axes)))
    if p.corners is not None:
        weights = rng.dirichlet(np.ones(len(p.corners)), 20)
        points = (
            weights @ p.corners
            + 3 * rng.random((20, len(p.rays))) @ p.rays
            + 3 * rng.normal(size=(20, len(p.free))) @ p.free
        )
        assert np.all(points @ both.T <= limits + 1e-8 * (1 + np.abs(points).max()))


@given(features(max_joints=9), st.sampled_from(["orientation", "nothing"]))
def test_speed_is_the_extent_of_the_polytope_and_the_judges(f, hold):
    """Three routes to one speed: the simplex here, the facets of the polytope of the same rows, and HiGHS."""
    model = f.model()
    if model.n == 0:
        return
    rng = np.random.default_rng(f.seed)
    q, d = f.configurations(), rng.normal(size=3)
    locked = rng.random(model.n) < 0.1
    limits = tuple(np.where(locked, 0.0, sign * rng.uniform(0.2, 2.0, model.n)) for sign in (-1, 1))
    s = ks.speed_capacity(model, q, d, hold=hold, velocity_limits=limits)
    J = without_rounding(model, ks.jacobian(model, q).array)[[("vx", "vy", "vz", "wx", "wy", "wz").index(r) for r in s.rows]]
    wanted = np.r_[s.direction, np.zeros(len(s.rows) - 3)]
    p = ks.velocity_polytope(model, q, task=s.rows, velocity_limits=limits)
    assert_close(s.value, p.extent(wanted), 1e-7)
    assert np.all((s.rates >= limits[0] - 1e-9) & (s.rates <= limits[1] + 1e-9))
    assert_close(J @ s.rates, s.value * wanted, 1e-9)
    sigma = [np.linalg.svd(rows, compute_uv=False) for rows in (J[:, ~locked], np.c_[J[:, ~locked], wanted])]
    if np.any((np.r_[*sigma] > 1e-13) & (np.r_[*sigma] < 1e-4)):
        return  # the judge lets equations go by 1e-7, which is much so near to a singularity
    assert s.is_lost == bool((sigma[0] > 1e-8).sum() < (sigma[1] > 1e-8).sum())
    best = linprog(
        np.r_[np.zeros(model.n), -1.0],
        A_eq=np.c_[J, -wanted],
        b_eq=np.zeros(len(wanted)),
        bounds=[*zip(*limits, strict=True), (0, 1e4)],
    )
    assert_close(s.value, -best.fun, 1e-6)


@given(features(max_joints=9))
def test_the_joints_named_are_those_that_limit(f):
    """Looser limits of the joints that are named raise the speed; looser limits of all others change nothing."""
    model = f.model()
    if model.n == 0:
        return
    rng = np.random.default_rng(f.seed)
    q, d, limits = f.configurations(), rng.normal(size=3), rng.uniform(0.2, 2.0, model.n)
    s = ks.speed_capacity(model, q, d, hold="nothing", velocity_limits=limits)
    if s.is_lost or s.value < 1e-6:
        return
    named = s.limiting != 0
    assert named.any()
    assert_close(np.sign(s.limiting[named]) * limits[named], s.rates[named], 1e-9)
    others = ks.speed_capacity(model, q, d, hold="nothing", velocity_limits=np.where(named, limits, 3 * limits))
    assert_close(others.value, s.value, 1e-8)
    looser = ks.speed_capacity(model, q, d, hold="nothing", velocity_limits=np.where(named, 1.1 * limits, limits))
    assert looser.value > s.value * (1 + 1e-9)
