"""Joint rates obey the laws they are named after: least squares, least norm, damping, strict order, limits."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, strategies as st

import kinestatics as ks
from kinestatics.namespaces import as_array
from kinestatics.spatial import change_twist_frame
from strategies import Features, assert_close, features

optimize = pytest.importorskip("scipy.optimize", reason="a judge of the dev extra")
cvxopt = pytest.importorskip("cvxopt", reason="a judge of the dev extra")

LIMIT = 1e-10  # below which singular values count as zero


def deficient(rng, rows, joints, rank):
    """A matrix of a given rank, with singular values between 0.1 and 1."""
    U, V = (np.linalg.qr(rng.normal(size=(size, size)))[0] for size in (rows, joints))
    k = min(rows, joints)
    sigma = np.where(np.arange(k) < rank, rng.uniform(0.1, 1.0, k), 0.0)
    return (U[:, :k] * sigma) @ V[:k]


def size_of_rows(array, length):
    """What rows of a twist are multiplied by, so that its size is |(v, length · ω)|."""
    return np.r_[np.ones(3), np.full(3, length)] if array.shape[-2] == 6 else np.ones(array.shape[-2])


# Least squares, least norm, free components


def test_nan_is_the_row_left_out():
    """2,000 systems with rank loss and free components: the pseudoinverse of the rows that are left, one by one."""
    rng = np.random.default_rng(1)
    for _ in range(2000):
        r, n = (int(x) for x in rng.integers(1, 9, 2))
        J = deficient(rng, r, n, int(rng.integers(0, min(r, n) + 1)))
        v = np.where(rng.random(r) < 0.3, np.nan, rng.normal(size=r))
        asked, length = ~np.isnan(v), float(rng.choice([1.0, 0.3]))
        sizes = size_of_rows(J, length)
        reduced = (sizes[:, None] * J)[asked]
        expected = np.linalg.pinv(reduced, rcond=LIMIT) @ (sizes * v)[asked] if asked.any() else np.zeros(n)
        found = ks.joint_rates(J, v, length=length)
        assert np.abs(found.array - expected).max() <= 1e-10 * max(1.0, np.abs(expected).max())
        left = np.linalg.matrix_rank(reduced, rtol=LIMIT) if asked.any() else 0
        assert found.rank == left
        assert np.all(np.asarray(found.residual)[~asked] == 0.0)


@pytest.mark.parametrize(
    ("method", "options"),
    [
        ("pseudoinverse", {}),
        ("weighted", {"weights": [1.0, 2.0, 0.5, 3.0, 1.0, 1.0, 0.2]}),
        ("damped", {"damping": 0.1}),
        ("adaptive", {}),
        ("qr", {}),
        ("qp", {"damping": 0.1}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_batches_are_their_members(method, options):
    """A batch with other free components in each twist gives what its members give, for every method."""
    rng = np.random.default_rng(2)
    J, v = rng.normal(size=(5, 4, 6, 7)), rng.normal(size=(4, 6))
    v[rng.random(v.shape) < 0.3] = np.nan
    v[2], v[3] = np.nan, np.abs(v[3])
    b = rng.normal(size=(5, 1, 7))
    found = ks.joint_rates(J, v, method, secondary=b, **options)
    assert found.array.shape == (5, 4, 7)
    for i in range(5):
        for k in range(4):
            one = ks.joint_rates(J[i, k], v[k], method, secondary=b[i, 0], **options)
            np.testing.assert_allclose(found.array[i, k], one.array, rtol=0, atol=1e-11)
            assert found.rank[i, k] == one.rank
            assert found.reachable[i, k] == one.reachable
            assert found.condition[i, k] == pytest.approx(one.condition)
            np.testing.assert_allclose(np.asarray(found.closest)[i, k], one.closest, atol=1e-11)
    many = ks.joint_rates(J[0, 0], v, method, **options)
    assert many.array.shape == (4, 7)
    assert many.rank.shape == many.reachable.shape == (4,)


@pytest.mark.parametrize(
    ("method", "options"),
    [
        ("pseudoinverse", {}),
        ("weighted", {"weights": 0.5}),
        ("damped", {"damping": 0.1}),
        ("adaptive", {}),
        ("qr", {}),
        ("qp", {}),
        ("qp", {"limits": 0.3, "keep_direction": True}),
    ],
    ids=lambda value: value if isinstance(value, str) else "-".join(value),
)
@pytest.mark.parametrize("name", ["planar_2r", "planar_3r", "scara", "stanford_arm", "panda"])
def test_a_task_is_nan_in_the_other_rows(name, method, options):
    """task=rows gives what NaN in all other rows gives, for every method, frame, batch and way to say the rows."""
    arm, rng = ks.load(name), np.random.default_rng(7)
    options = {key: value if value is True or key == "damping" else np.full(arm.n, value) for key, value in options.items()}
    J = ks.jacobian(arm, arm.random_configurations(3, seed=1))
    v = rng.normal(size=(3, 6))
    v[1, 0] = np.nan
    tasks = ["auto", "position", "orientation", "full", "vx", "vy,wz", ["wx", "vx"], [5, 0], np.array([2])]
    for frame in (J.frame, ks.Frame.body()):
        matrix = J.change_frame(frame)
        for task in tasks:
            rows = ks.find_task(arm, task, frame=frame).rows
            free = np.where(np.isin(np.arange(6), rows), v, np.nan)
            found, expected = (
                ks.joint_rates(matrix, v, method, task=task, **options),
                ks.joint_rates(matrix, free, method, **options),
            )
            np.testing.assert_array_equal(found.array, expected.array)
            np.testing.assert_array_equal(found.rank, expected.rank)
            np.testing.assert_array_equal(found.residual, expected.residual)
            assert found.task == ks.find_task(arm, task, frame=frame).row_names
            one = ks.joint_rates(matrix.array[2], v[2], method, task=list(rows), **options)
            np.testing.assert_allclose(found.array[2], one.array, rtol=0, atol=1e-9 * (1 + np.abs(one.array).max()))


def test_an_arm_reaches_its_own_task():
    """Of every arm with as many freedoms as rows in play, a twist with anything in the other rows is made in these."""
    counted = 0
    for name in ks.catalogue_names():
        arm = ks.load(name)
        task = ks.find_task(arm) if arm.n else None
        if task is None or task.rank < len(task.rows):
            continue
        q = arm.random_configurations(1, seed=5)[0]
        J, rows, v = ks.jacobian(arm, q), list(task.rows), np.linspace(-1.0, 1.5, 6)
        found = ks.joint_rates(J, v, task="auto")
        assert found.reachable
        np.testing.assert_allclose(found.achieved.array[rows], v[rows], atol=1e-8)
        counted += len(rows) < 6
    assert counted >= 3


def test_nothing_asked_is_nothing_done():
    """All components free: no motion, rank 0, reachable; a secondary motion is then free."""
    found = ks.joint_rates(np.ones((6, 3)), [np.nan] * 6, secondary=[1.0, 2.0, 3.0])
    np.testing.assert_allclose(found.array, [1, 2, 3])
    assert (found.rank, found.rank_augmented, bool(found.reachable)) == (0, 0, True)
    assert np.all(ks.joint_rates(np.ones((6, 3)), [np.nan] * 6).array == 0.0)


@given(features(max_joints=7), st.floats(0.1, 10.0))
def test_least_squares_and_least_norm(f, length):
    """On every mechanism: Jᵀ(J q̇ - ξ) = 0 in the size of the twist, and q̇ is at right angles to all null motion."""
    model = f.model()
    if model.n == 0:
        return
    rng = np.random.default_rng(f.seed)
    J = ks.jacobian(model, f.configurations())
    twist = ks.Twist.of(rng.normal(size=3), rng.normal(size=3), frame=J.frame)
    found = ks.joint_rates(J, twist, length=length)
    sizes = size_of_rows(J.array, length)
    scaled, target = sizes[:, None] * J.array, sizes * twist.array
    bound = 1e-9 * max(1.0, float(found.condition) if np.isfinite(found.condition) else 1.0)
    largest = np.linalg.norm(scaled, 2)
    small = 1e-13 * largest * (largest * np.linalg.norm(found.array) + np.linalg.norm(target))
    dropped = found.tolerance * largest * np.linalg.norm(found.array)  # what singular values below the tolerance are worth
    assert np.abs(scaled.T @ (scaled @ found.array - target)).max() <= small + dropped
    assert np.abs(found.null_motion @ found.array).max(initial=0.0) <= bound * max(1.0, np.abs(found.array).max())
    assert found.null_motion.shape == (model.n - found.rank, model.n)
    assert_close(found.residual, twist.array - np.asarray(found.achieved), 1e-12)
    assert_close(found.achieved, found.closest, 1e-9)


@given(features(max_joints=7))
def test_what_the_arm_can_do_is_reachable_in_every_frame(f):
    """A twist J q̇ is reachable, in every frame, and made exactly; the sentence says so."""
    model = f.model()
    if model.n == 0:
        return
    q, rates = f.configurations(), np.random.default_rng(f.seed + 2).normal(size=model.n)
    J = ks.jacobian(model, q)
    for frame in (J.frame, ks.Frame.body(), ks.Frame.spatial()):
        there = J.change_frame(frame)
        sigma = np.linalg.svd(there.array, compute_uv=False)
        if np.any((sigma > 1e-14 * sigma[0]) & (sigma < 1e-6 * sigma[0])):
            continue  # neither lost nor there: the answer depends on the tolerance
        found = ks.joint_rates(there, there @ rates)
        assert found.reachable
        assert found.reason == f"reachable: rank J = rank [J | ξ] = {found.rank}"
        assert_close(found.achieved, (there @ rates).array, 1e-7)


def test_the_answer_does_not_depend_on_the_frame():
    """A reachable twist, rewritten in other frames, asks for the same rates."""
    arm = ks.load("iiwa_14")
    q = arm.random_configurations(1, seed=4)[0]
    J = ks.jacobian(arm, q)
    twist = ks.Twist.of((0.1, 0.2, -0.3), (0.2, 0.1, 0.4))
    expected = ks.joint_rates(J, twist).array
    T = ks.pose(arm, q).array
    for frame, R, p in ((ks.Frame.body(), T[:3, :3], np.zeros(3)), (ks.Frame.spatial(), np.eye(3), -T[:3, 3])):
        array = change_twist_frame(twist.array, R, p, as_array(q)[1])
        found = ks.joint_rates(J.change_frame(frame), ks.Twist(array, frame))
        np.testing.assert_allclose(found.array, expected, atol=1e-12)


# The rank test


def exact_rank(rows):
    """Rank of a matrix of fractions, by elimination without rounding."""
    rows, rank = [[Fraction(x) for x in row] for row in rows], 0
    for column in range(len(rows[0])):
        pivot = next((i for i in range(rank, len(rows)) if rows[i][column] != 0), None)
        if pivot is None:
            continue
        rows[rank], rows[pivot] = rows[pivot], rows[rank]
        for i in range(rank + 1, len(rows)):
            factor = rows[i][column] / rows[rank][column]
            rows[i] = [a - factor * b for a, b in zip(rows[i], rows[rank], strict=True)]
        rank += 1
        if rank == len(rows):
            break
    return rank


def test_rank_test_is_that_of_exact_fractions():
    """Integer systems of every rank, twists inside and outside the range, any scale: the ranks of exact elimination."""
    rng = np.random.default_rng(3)
    reachable = 0
    for _ in range(1500):
        r, n, k = (int(x) for x in rng.integers(1, 7, 3))
        J = rng.integers(-4, 5, (r, k)) @ rng.integers(-4, 5, (k, n))
        v = J @ rng.integers(-3, 4, n) if rng.random() < 0.5 else rng.integers(-3, 4, r)
        scale = 10.0 ** rng.integers(-8, 9)
        found = ks.joint_rates(J * 1.0, v * scale)
        both = np.c_[J, v].tolist()
        assert (found.rank, found.rank_augmented) == (exact_rank(J.tolist()), exact_rank(both))
        assert found.reachable == (found.rank == found.rank_augmented)
        reachable += bool(found.reachable)
    assert 500 < reachable < 1400


# The identities of note 000


@pytest.mark.parametrize("shape", [(6, 8), (6, 4), (6, 6), (3, 7), (1, 1)], ids=str)
@pytest.mark.parametrize("method", ["pseudoinverse", "qr"])
def test_identities_of_the_pseudoinverse(shape, method):
    """Note 000: J⁺ = Jᵀ(J Jᵀ)⁻¹ where wide, (JᵀJ)⁻¹Jᵀ where tall; J J⁺ = I, J⁺ J = I; J (I - J⁺J) b = 0."""
    rng = np.random.default_rng(4)
    r, n = shape
    J = rng.normal(size=shape)
    inverse = ks.joint_rates(J, np.eye(r), method).array.T  # one twist a row: the columns of J⁺
    closed = J.T @ np.linalg.inv(J @ J.T) if r <= n else np.linalg.inv(J.T @ J) @ J.T
    np.testing.assert_allclose(inverse, closed, atol=1e-12)
    if r <= n:
        np.testing.assert_allclose(J @ inverse, np.eye(r), atol=1e-13)
    if r >= n:
        np.testing.assert_allclose(inverse @ J, np.eye(n), atol=1e-13)
    if r < n:
        assert np.abs(inverse @ J - np.eye(n)).max() > 0.1
    b, v = rng.normal(size=n), rng.normal(size=r)
    plain, moved = ks.joint_rates(J, v, method), ks.joint_rates(J, v, method, secondary=b)
    np.testing.assert_allclose(moved.array, plain.array + (np.eye(n) - inverse @ J) @ b, atol=1e-12)
    np.testing.assert_allclose(moved.array, plain.member(b), atol=1e-12)
    np.testing.assert_allclose(J @ moved.array, J @ plain.array, atol=1e-12)
    assert np.linalg.norm(plain.array) <= np.linalg.norm(moved.array) + 1e-12
    assert not moved.by_svd if method == "qr" else moved.by_svd is None


def test_qr_hands_over_where_rank_is_missing():
    """Without full rank, or close to that, QR says that the SVD took over, and gives what the pseudoinverse gives."""
    rng = np.random.default_rng(5)
    J = np.stack([deficient(rng, 6, 7, rank) for rank in (6, 5, 3, 0)] + [rng.normal(size=(6, 7))])
    J[4, 5] = J[4, 4] * (1.0 + 1e-12)  # as good as dependent, with pivots that are not small for certain
    v = rng.normal(size=(5, 6))
    found = ks.joint_rates(J, v, "qr")
    assert found.by_svd.tolist() == [False, True, True, True, True]
    np.testing.assert_allclose(found.array[:4], ks.joint_rates(J, v).array[:4], atol=1e-12)
    free = ks.joint_rates(J[0], [1.0, np.nan, 0.0, np.nan, 1.0, 0.0], "qr")
    assert not free.by_svd
    np.testing.assert_allclose(free.array, ks.joint_rates(J[0], [1.0, np.nan, 0.0, np.nan, 1.0, 0.0]).array, atol=1e-12)
    kahan = np.triu(-np.ones((60, 60)), 1) + np.eye(60)  # singular to working precision, all pivots 1
    assert ks.joint_rates(kahan.T, np.ones(60), "qr").by_svd


# Joint weights


@pytest.mark.parametrize("full", [False, True], ids=["one weight a joint", "a mass matrix"])
def test_weighted_is_the_lagrangian_solution(full):
    """min q̇ᵀWq̇ with J q̇ = ξ, against the linear system of the Lagrangian; the null part is that of W too."""
    rng = np.random.default_rng(6)
    for _ in range(50):
        r, n = int(rng.integers(1, 5)), int(rng.integers(5, 9))
        J, v, b = rng.normal(size=(r, n)), rng.normal(size=r), rng.normal(size=n)
        W = np.diag(10.0 ** rng.uniform(-2, 2, n))
        if full:
            R = rng.normal(size=(n, n))
            W = R @ R.T + 0.1 * np.eye(n)
        system = np.block([[W, J.T], [J, np.zeros((r, r))]])
        expected = np.linalg.solve(system, np.r_[np.zeros(n), v])[:n]
        weights = W if full else np.diag(W)
        found = ks.joint_rates(J, v, "weighted", weights=weights)
        np.testing.assert_allclose(found.array, expected, atol=1e-9)
        # nearest to b in the norm of W among all that make the twist
        near = np.linalg.solve(system, np.r_[W @ b, v])[:n]
        np.testing.assert_allclose(ks.joint_rates(J, v, "weighted", weights=weights, secondary=b).array, near, atol=1e-9)
        np.testing.assert_allclose(found.member(b), near, atol=1e-9)
        for method, options in (("qr", {}), ("qp", {"damping": 1e-6})):
            other = ks.joint_rates(J, v, method, weights=weights, secondary=b, **options)
            np.testing.assert_allclose(other.array, near, atol=1e-7)


def test_damped_with_weights():
    """|J q̇ - ξ|² + λ² q̇ᵀWq̇, against the normal equations."""
    rng = np.random.default_rng(7)
    J, v, w = rng.normal(size=(6, 7)), rng.normal(size=6), rng.uniform(0.5, 2.0, 7)
    expected = np.linalg.solve(J.T @ J + 0.04 * np.diag(w), J.T @ v)
    for method in ("damped", "qp"):
        np.testing.assert_allclose(ks.joint_rates(J, v, method, damping=0.2, weights=w).array, expected, atol=1e-12)


# Damping


@given(st.integers(0, 2**31 - 1), st.floats(-3, 1))
def test_damped_is_the_augmented_least_squares(seed, exponent):
    """Jᵀ(J Jᵀ + λ²I)⁻¹ξ, against least squares of (J; λ I), whatever the rank."""
    rng = np.random.default_rng(seed)
    r, n, damping = int(rng.integers(1, 8)), int(rng.integers(1, 9)), 10.0**exponent
    J, v = deficient(rng, r, n, int(rng.integers(0, min(r, n) + 1))), rng.normal(size=r)
    sizes = size_of_rows(J, 1.0)
    stacked = np.vstack([sizes[:, None] * J, damping * np.eye(n)])
    expected = np.linalg.lstsq(stacked, np.r_[sizes * v, np.zeros(n)], rcond=None)[0]
    found = ks.joint_rates(J, v, "damped", damping=damping)
    rounding = 4e-16 * np.linalg.norm(v) / damping**2  # what the last digit of J is worth where J has no full rank
    assert np.abs(found.array - expected).max() <= 4 * rounding + 1e-13
    assert np.linalg.norm(found.array) <= np.linalg.norm(v) / (2 * damping) * (1 + 1e-12)


def test_damping_survives_extreme_scales():
    """No square overflows or vanishes: the law holds when J, ξ and λ are 1e-160 or 1e160 times as large."""
    rng = np.random.default_rng(8)
    J, v = rng.normal(size=(3, 4)), rng.normal(size=3)
    expected = ks.joint_rates(J, v, "damped", damping=0.1).array
    for scale in (1e-160, 1e160):
        found = ks.joint_rates(J * scale, v * scale, "damped", damping=0.1 * scale)
        np.testing.assert_allclose(found.array, expected, rtol=1e-12)


def test_adaptive_damps_only_what_is_nearly_lost():
    """Outside the region it is the pseudoinverse; inside, only the components along weak directions are changed."""
    rng = np.random.default_rng(9)
    U, V = (np.linalg.qr(rng.normal(size=(k, k)))[0] for k in (6, 7))
    strong = np.array([1.0, 0.8, 0.5, 0.3, 0.1])
    for least in (0.5, 0.021, 0.019, 1e-3, 1e-7, 1e-14, 0.0):
        J = (U * np.r_[strong, least]) @ V[:, :6].T
        v = rng.normal(size=6)
        found = ks.joint_rates(J, v, "adaptive")
        wanted = (U.T @ v) / np.r_[strong, 1.0]
        np.testing.assert_allclose((V.T @ found.array)[:5], wanted[:5], atol=1e-12)
        if least > 0.02:
            np.testing.assert_allclose(found.array, ks.joint_rates(J, v).array, atol=1e-12)
            assert np.all(found.damping == 0.0)
        weak = abs((V.T @ found.array)[5])
        assert weak <= abs((U.T @ v)[5]) / 0.02 * (1 + 1e-9)
        assert np.linalg.norm(found.array) <= np.linalg.norm(v) / 0.02 * (1 + 1e-9)


def test_adaptive_gain_grows_to_the_edge_and_falls_behind_it():
    """The gain σ/(σ² + λ²) is continuous, never above 1/ε, with its greatest value at the edge of the region."""
    sigma = np.concatenate([np.linspace(1e-6, 0.02, 400), np.linspace(0.02, 1.0, 400)])
    J = np.stack([np.ones_like(sigma), np.zeros_like(sigma), np.zeros_like(sigma), sigma], -1).reshape(-1, 2, 2)
    gain = ks.joint_rates(J, [0.0, 1.0], "adaptive").array[:, 1]
    assert np.all(np.diff(gain[:400]) > 0)
    assert np.all(np.diff(gain[400:]) < 0)
    assert gain.max() == pytest.approx(50.0, rel=1e-9)
    assert abs(gain[399] - gain[400]) < 1e-9
    chosen = ks.joint_rates(J, [0.0, 1.0], "adaptive", damping=0.1, region=0.5).array[:, 1]
    square = 0.1**2 * np.maximum(1.0 - (sigma / 0.5) ** 2, 0.0)  # Chiaverini 1997
    np.testing.assert_allclose(chosen, sigma / (sigma**2 + square), rtol=1e-12)


# Limits by slowing down


def bounds_for(rng, n, around_zero=True):
    lower, upper = -rng.uniform(0.05, 1.0, n), rng.uniform(0.05, 1.0, n)
    if not around_zero:
        shift = rng.normal(size=n) * 0.5
        lower, upper = lower + shift, upper + shift
    unbounded = rng.random(n) < 0.2
    return np.where(unbounded, -np.inf, lower), np.where(rng.random(n) < 0.2, np.inf, upper)


@given(st.integers(0, 2**31 - 1), st.booleans(), st.booleans())
def test_slowing_down_keeps_direction_and_limits(seed, around_zero, with_secondary):
    """Inside the limits, exactly along the twist to 1e-12, and no share of the speed would be greater (linear program)."""
    rng = np.random.default_rng(seed)
    r, n = int(rng.integers(1, 6)), int(rng.integers(5, 9))
    J, v = rng.normal(size=(r, n)), rng.normal(size=r) * 10.0 ** rng.uniform(-1, 2)
    b = rng.normal(size=n) if with_secondary else None
    lower, upper = bounds_for(rng, n, around_zero)
    free = ks.joint_rates(J, v)
    found = ks.joint_rates(J, v, limits=(lower, upper), secondary=b)
    assert found.limits.contains(found.array)
    null = free.member(b) - free.array if with_secondary else np.zeros(n)
    both, most = np.tile(np.c_[free.array, null], (2, 1)) * np.repeat([1, -1], n)[:, None], np.r_[upper, -lower]
    bounded = np.isfinite(most)
    program = optimize.linprog([-1, 0], both[bounded], most[bounded], bounds=[(0, 1), (0, 1)])
    if not around_zero and program.status == 2:
        assert not found.keeps_direction
        assert found.scale == 0.0
        np.testing.assert_allclose(found.array, np.clip(free.array + null, lower, upper), atol=1e-12)
        return
    assert found.keeps_direction
    assert abs(found.scale - program.x[0]) <= 1e-7
    size = np.linalg.norm(v)
    assert np.abs(np.asarray(found.achieved) - found.scale * v).max() <= 1e-12 * size * max(1.0, float(found.condition))
    if not with_secondary:
        assert np.abs(found.array - found.scale * free.array).max() <= 1e-14 * np.abs(free.array).max()


@given(features(max_joints=7), st.sampled_from(["pseudoinverse", "damped", "adaptive", "weighted", "qr", "qp", "direction"]))
@example(Features(seed=918769, joints=7, right_angles=True), "direction")  # bounds that follow from one another
@example(Features(seed=918767, joints=7, right_angles=True), "direction")
def test_limits_are_never_exceeded(f, method):
    """Whatever the mechanism, method, singularity and twist: not by one bit."""
    model = f.model()
    if model.n == 0:
        return
    rng = np.random.default_rng(f.seed)
    J = ks.jacobian(model, f.configurations(3))
    twist = ks.Twist(rng.normal(size=6) * 10.0 ** rng.uniform(-2, 3), J.frame)
    limits = bounds_for(rng, model.n, around_zero=rng.random() < 0.5)
    options = {
        "damped": {"damping": 0.1},
        "weighted": {"weights": rng.uniform(0.1, 9, model.n)},
        "direction": {"keep_direction": True},
    }
    name = "qp" if method == "direction" else method
    found = ks.joint_rates(J, twist, name, limits=limits, secondary=rng.normal(size=model.n), **options.get(method, {}))
    assert np.all(found.array >= limits[0])
    assert np.all(found.array <= limits[1])
    assert np.all((found.scale >= 0) & (found.scale <= 1))


# Limits by quadratic programs


def test_the_program_is_that_of_an_independent_solver():
    """min |J q̇ - ξ|² + λ²|q̇ - b|² inside bounds: the bounded least squares of SciPy, to 1e-8."""
    rng = np.random.default_rng(10)
    met = 0
    for _ in range(300):
        r, n = int(rng.integers(1, 8)), int(rng.integers(1, 9))
        J = deficient(rng, r, n, int(rng.integers(0, min(r, n) + 1)))
        v, b, damping = rng.normal(size=r), rng.normal(size=n), 10.0 ** rng.uniform(-2, 0)
        lower, upper = bounds_for(rng, n, around_zero=rng.random() < 0.7)
        found = ks.joint_rates(J, v, "qp", limits=(lower, upper), damping=damping, secondary=b)
        stacked = np.vstack([J, damping * np.eye(n)])
        judge = optimize.lsq_linear(stacked, np.r_[v, damping * b], (lower, upper), method="bvls", tol=1e-15, max_iter=1000)
        np.testing.assert_allclose(found.array, judge.x, atol=1e-8)
        assert found.keeps_direction == (not np.any(found.at_limit))
        met += np.any(found.at_limit)
    assert met > 100


def test_the_program_is_the_optimum_at_the_least_damping():
    """With the damping that only decides between equals, down to nearly lost directions: no feasible rates cost less.

    Judged by the conditions of Karush, Kuhn and Tucker in exact fractions of the numbers found.
    """
    rng = np.random.default_rng(11)
    for _ in range(150):
        r, n = int(rng.integers(1, 7)), int(rng.integers(2, 8))
        U, V = (np.linalg.qr(rng.normal(size=(k, k)))[0] for k in (r, n))
        k = min(r, n)
        J, v = (U[:, :k] * 10.0 ** rng.uniform(-8, 0, k)) @ V[:k], rng.normal(size=r)
        lower, upper = -rng.uniform(0.1, 2.0, n), rng.uniform(0.1, 2.0, n)
        found = ks.joint_rates(J, v, "qp", limits=(lower, upper))
        damping = float(found.damping)
        assert damping == pytest.approx(1e-6 * np.linalg.norm(J, 2))
        slope = J.T @ (J @ found.array - v) + damping**2 * found.array
        rounding = 1e-13 * np.linalg.norm(J, 2) * (np.linalg.norm(v) + np.linalg.norm(J, 2))
        below, above = found.array <= lower, found.array >= upper
        assert np.all(np.abs(slope[~below & ~above]) <= rounding)
        assert np.all(slope[below] >= -rounding)
        assert np.all(slope[above] <= rounding)


def test_without_binding_limits_the_program_is_the_pseudoinverse():
    """Wide limits, or none: what is reachable is reached."""
    rng = np.random.default_rng(12)
    J, v = rng.normal(size=(20, 6, 7)), rng.normal(size=(20, 6))
    expected = ks.joint_rates(J, v).array
    for limits in (None, (np.full(7, -1e3), np.full(7, 1e3))):
        np.testing.assert_allclose(ks.joint_rates(J, v, "qp", limits=limits).array, expected, rtol=1e-7, atol=1e-7)
    along = ks.joint_rates(J, v, "qp", limits=(np.full(7, -1e3), np.full(7, 1e3)), keep_direction=True)
    np.testing.assert_allclose(along.array, expected, atol=1e-12)
    assert np.all(along.scale == 1.0)


@given(st.integers(0, 2**31 - 1), st.booleans(), st.booleans())
@example(542105, False, False)  # a great change of rates for the last millionth of the speed
def test_direction_is_kept_at_the_greatest_speed(seed, around_zero, weighted):
    """J q̇ = s ξ with s as great as a linear program over all rates makes it, and then the smallest rates."""
    rng = np.random.default_rng(seed)
    r, n = int(rng.integers(1, 6)), int(rng.integers(3, 8))
    J = rng.normal(size=(r, n))
    v = J @ rng.normal(size=n) * 10.0 ** rng.uniform(-1, 2)
    lower, upper = bounds_for(rng, n, around_zero)
    weights = {"weights": rng.uniform(0.3, 3.0, n)} if weighted else {}
    found = ks.joint_rates(J, v, "qp", limits=(lower, upper), keep_direction=True, **weights)
    box = [*zip(lower, upper, strict=True), (0, 1)]
    cost = np.r_[np.zeros(n), -1.0]
    program = optimize.linprog(cost, A_eq=np.c_[J, -v], b_eq=np.zeros(r), bounds=box)
    if program.status == 2:
        assert (found.scale, bool(found.keeps_direction)) == (0.0, False)
        return
    assert found.keeps_direction
    assert abs(found.scale + program.fun) <= 1e-7
    assert np.abs(J @ found.array - found.scale * v).max() <= 1e-11 * np.linalg.norm(v) * np.linalg.cond(J)
    slower = ks.joint_rates(J, v, limits=(lower, upper))
    if slower.keeps_direction:
        assert found.scale >= slower.scale - 1e-9


# Priorities


def hierarchy(levels, n):
    """Strict order by brute force: each level by least squares among the optima of those before, which are kept as
    equations with exact null spaces."""
    x, N = np.zeros(n), np.eye(n)
    for J, v in levels:
        A = J @ N
        own = np.linalg.norm(J, 2)
        x = x + N @ (np.linalg.pinv(A, rcond=1e-9 * own / max(np.linalg.norm(A, 2), 1e-300)) @ (v - J @ x))
        _, sigma, Vt = np.linalg.svd(A)
        N = N @ Vt[int((sigma > 1e-9 * own).sum()) :].T
    return x


@given(st.integers(0, 2**31 - 1), st.integers(1, 4))
@example(801, 3)  # a weak direction at the third level, rates of 1e5
def test_priorities_are_strict(seed, count):
    """The first task is as good as alone; each other as good as the null space of those before lets it be."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 9))
    levels = []
    for _ in range(count):
        r = int(rng.integers(1, 5))
        J = deficient(rng, r, n, int(rng.integers(1, min(r, n) + 1)))
        if levels and rng.random() < 0.4:  # rows that conflict with a task before
            J[0] = rng.normal(size=len(levels[-1][0])) @ levels[-1][0]
        levels.append((J, rng.normal(size=r)))
    found = ks.prioritized_rates(levels)
    assert_close(found.array, hierarchy(levels, n), 1e-8)
    alone = ks.joint_rates(*levels[0])
    assert abs(found.tasks[0].missing - np.linalg.norm(alone.residual)) <= 1e-12 * max(1.0, np.abs(found.array).max())
    kept = [ks.prioritized_rates(levels[: k + 1]) for k in range(count)]
    for k, some in enumerate(kept):  # a task less at the end changes nothing of those before
        for i in range(k + 1):
            size = max(1.0, np.abs(found.array).max())
            assert np.abs(np.asarray(some.tasks[i].achieved) - np.asarray(found.tasks[i].achieved)).max() <= 1e-11 * size
    damped = ks.prioritized_rates(levels, damping=0.3)
    first = ks.joint_rates(*levels[0], "damped", damping=0.3)
    assert np.abs(np.asarray(damped.tasks[0].achieved) - np.asarray(first.achieved)).max() <= 1e-11


def test_tasks_that_nearly_conflict_do_not_leak():
    """What is left of the second task is 1e-9 of it: large rates, and still nothing of them in the first task."""
    rng = np.random.default_rng(13)
    J1 = rng.normal(size=(3, 7))
    J2 = np.vstack([J1[0] + 1e-9 * rng.normal(size=7), rng.normal(size=7)])
    found = ks.prioritized_rates([(J1, [1.0, 2.0, 3.0]), (J2, [5.0, -1.0])])
    assert np.abs(found.array).max() > 1e8
    assert found.tasks[0].missing <= 1e-14 * np.abs(found.array).max()
    exact = ks.prioritized_rates([(J1, [1.0, 2.0, 3.0]), (J1[:2] + 0.0, [5.0, -1.0])])  # in conflict: rounding is left
    assert np.abs(exact.array).max() < 10
    np.testing.assert_allclose(exact.array, ks.joint_rates(J1, [1.0, 2.0, 3.0]).array, atol=1e-12)


def test_priorities_of_a_batch_are_those_of_its_members():
    """Ranks that differ from member to member, free components that differ too."""
    rng = np.random.default_rng(14)
    J1 = np.stack([deficient(rng, 3, 7, k) for k in (3, 2, 1, 0)])
    J2, J3 = rng.normal(size=(4, 6, 7)), rng.normal(size=(2, 7))
    v1, v2, v3 = rng.normal(size=3), rng.normal(size=(4, 6)), rng.normal(size=(4, 2))
    v2[1, :3], v2[3] = np.nan, np.nan
    limits = (np.full(7, -0.5), np.full(7, 0.6))
    for options in ({}, {"damping": 0.2}, {"limits": limits}):
        found = ks.prioritized_rates([(J1, v1), (J2, v2), (J3, v3)], **options)
        for k in range(4):
            one = ks.prioritized_rates([(J1[k], v1), (J2[k], v2[k]), (J3, v3[k])], **options)
            np.testing.assert_allclose(found.array[k], one.array, atol=1e-9)
            for many, single in zip(found.tasks, one.tasks, strict=True):
                assert many.achieved_fully[k] == single.achieved_fully


def program_of(J, v, lower, upper, A, b):
    """min |J x - v|² inside bounds with A x = b, by the interior-point method of CVXOPT."""
    n = J.shape[1]
    matrices = (J.T @ J + 1e-14 * np.eye(n), -J.T @ v, np.vstack([np.eye(n), -np.eye(n)]), np.r_[upper, -lower])
    equations = (cvxopt.matrix(A), cvxopt.matrix(b)) if len(b) else ()
    options = {"show_progress": False, "abstol": 1e-12, "reltol": 1e-12, "feastol": 1e-12}
    return np.array(cvxopt.solvers.qp(*(cvxopt.matrix(m) for m in matrices), *equations, options=options)["x"]).ravel()


def test_priorities_inside_limits_are_strict():
    """With limits: the first task as good as alone inside them, to 1e-8, whatever comes behind; none exceeds a limit."""
    rng = np.random.default_rng(15)
    for _ in range(60):
        n = int(rng.integers(3, 8))
        levels = [(rng.normal(size=(r, n)), rng.normal(size=r) * 2) for r in rng.integers(1, 4, 3)]
        lower, upper = -rng.uniform(0.1, 1.0, n), rng.uniform(0.1, 1.0, n)
        found = ks.prioritized_rates(levels, limits=(lower, upper))
        assert found.limits.contains(found.array)
        kept = np.zeros((0, n)), np.zeros(0)  # what the levels before achieve, as independent equations
        for J, v in levels:
            judge = program_of(J, v, lower, upper, *kept)
            best = np.linalg.norm(J @ judge - v)
            assert np.linalg.norm(J @ found.array - v) <= best + 1e-6
            assert np.abs(kept[0] @ found.array - kept[1]).max(initial=0.0) <= 1e-6
            _, sigma, Vt = np.linalg.svd(np.vstack([kept[0], J]))
            rows = Vt[: int((sigma > 1e-9 * sigma[0]).sum())]
            kept = rows, rows @ judge
        alone = ks.joint_rates(*levels[0], "qp", limits=(lower, upper))
        best = np.linalg.norm(np.asarray(alone.residual))
        assert abs(np.linalg.norm(found.tasks[0].residual) - best) <= 1e-8


def test_wide_limits_change_no_priorities():
    """The cascade of programs gives what the recursion of projectors gives where no limit binds."""
    rng = np.random.default_rng(16)
    for _ in range(40):
        n = int(rng.integers(3, 8))
        levels = [(rng.normal(size=(r, n)), rng.normal(size=r)) for r in rng.integers(1, 4, 3)]
        free = ks.prioritized_rates(levels)
        wide = np.full(n, 10 * np.abs(free.array).max())
        np.testing.assert_allclose(
            ks.prioritized_rates(levels, limits=(-wide, wide)).array, free.array, rtol=1e-7, atol=1e-7
        )
