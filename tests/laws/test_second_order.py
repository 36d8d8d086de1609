"""Laws of the second order at singular postures: what does not change the class, and what the class promises nearby."""

from dataclasses import replace

import numpy as np
from hypothesis import assume, given, strategies as st

import kinestatics as ks
from kinestatics.singular_sets.axes import axis_relations
from kinestatics.singular_sets.pencils import most_definite, passes
from kinestatics.singular_sets.second_order import second_order
from kinestatics.singular_sets.task_map import polished, task_map
from kinestatics.spatial import quaternion_to_rotation

SEEDS = st.integers(0, 2**31 - 1)
PI = np.pi


def random_arm(seed, n, scale=1.0, base=None):
    """A spatial arm of revolute joints with general lengths and twists."""
    rng = np.random.default_rng(seed)
    rows = [(scale * rng.uniform(0.1, 1), rng.uniform(-PI, PI), scale * rng.uniform(-0.5, 0.5), 0.0) for _ in range(n)]
    return ks.from_dh(rows, convention="standard", base=base)


def singular_posture(arm, task, seed):
    q = np.random.default_rng(seed + 1).uniform(-PI, PI, arm.n)
    found, left = polished(arm, q, task)
    assume(left < 1e-14)
    assume(np.linalg.norm(found) < 20)
    return found


def clear(second):
    """Whether no eigenvalue is so near zero that rounding in another description may turn it."""
    return second.kind in ("barrier", "crossable") and np.abs(second.eigenvalues).min() > 1e-4


def beyond(of, second, q, tries, radius, seed):
    """w · displacement of postures near q whose other rows are where they were: g(0, y) of Lyapunov and Schmidt."""
    y, rng = q / of.travel, np.random.default_rng(seed)
    R, p = of.place(y)
    U, _, _ = np.linalg.svd(of.jacobian(y))
    others = U[:, : second.rank]
    w = (second.directions[0] * np.r_[np.ones(3), np.full(3, of.length)])[list(of.rows)] @ of.live
    w = w / np.linalg.norm(w)
    x = y + radius * rng.normal(size=(tries, len(y)))
    for _ in range(12):
        x = x - (np.linalg.pinv(others.T @ of.jacobian(x)) @ (of.residual(x, R, p) @ others)[..., None])[..., 0]
    r = of.residual(x, R, p)
    near = (np.abs(r @ others).max(-1) < 1e-13) & (np.linalg.norm(x - y, axis=-1) < 5 * radius * len(y) ** 0.5)
    return r[near] @ w


@given(SEEDS, st.sampled_from([3, 4]))
def test_the_class_is_what_is_seen_nearby(seed, n):
    """A barrier's neighbours stay on one side of it; a crossable posture has neighbours on both."""
    arm = random_arm(seed, n)
    task = ks.find_task(arm, "position")
    q = singular_posture(arm, task, seed)
    second = second_order(arm, q, task)
    assume(clear(second) and np.abs(second.eigenvalues).min() > 0.02)
    found = beyond(task_map(arm, task), second, second.q, 40, 1e-3, seed)
    assert len(found) > 20
    if second.kind == "barrier":
        assert found.min() >= -1e-13
        assert found.max() > 1e-9
    else:
        assert found.min() < -1e-10
        assert found.max() > 1e-10


@given(SEEDS)
def test_six_rows_too(seed):
    """The same with all six rows, whose angular part has a derivative that is not symmetric."""
    arm = random_arm(seed, 6)
    task = ks.find_task(arm, "full")
    q = singular_posture(arm, task, seed)
    second = second_order(arm, q, task)
    assume(second.kind == "barrier" and second.eigenvalues[0] > 0.02)
    found = beyond(task_map(arm, task), second, second.q, 20, 1e-3, seed)
    assert len(found) > 5
    assert found.min() >= -1e-13


@given(SEEDS, st.sampled_from([(3, "position"), (4, "position"), (6, "full"), (7, "full")]), st.floats(-3, 3))
def test_axes_and_lengths_do_not_matter(seed, kind, power):
    """Another base, another unit of length, other senses of the joints: the same class, the same eigenvalues."""
    n, rows = kind
    arm = random_arm(seed, n)
    task = ks.find_task(arm, rows)
    q = singular_posture(arm, task, seed)
    second = second_order(arm, q, task)
    assume(clear(second))
    rng = np.random.default_rng(seed + 2)
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = quaternion_to_rotation(*rng.normal(size=4)), rng.normal(size=3)
    signs = rng.choice([-1.0, 1.0], n)
    others = (
        (random_arm(seed, n, base=base), q),
        (random_arm(seed, n, scale=10.0**power), q),
        (replace(arm, multipliers=signs), q * signs),
    )
    for other, posture in others:
        found = second_order(other, posture, ks.find_task(other, rows), tolerance=1e-9)
        assert (found.kind, found.rank) == (second.kind, second.rank)
        expected = second.eigenvalues if found.kind == "barrier" else np.sort(np.abs(second.eigenvalues))
        seen = found.eigenvalues if found.kind == "barrier" else np.sort(np.abs(found.eigenvalues))
        assert np.abs(seen - expected).max() < 1e-7


@given(SEEDS, st.floats(0.1, 10))
def test_the_length_does_not_change_the_class(seed, length):
    arm = random_arm(seed, 6)
    task = ks.find_task(arm, "full")
    second = second_order(arm, singular_posture(arm, task, seed), task)
    assume(clear(second))
    assert second_order(arm, second.q, task, length=length).kind == second.kind


@given(SEEDS)
def test_polished_posture_loses_rank(seed):
    """Where it arrives, the least singular value is rounding, and stays so when it is polished again."""
    arm = random_arm(seed, 6)
    task = ks.find_task(arm, "full")
    q = singular_posture(arm, task, seed)
    again, left = polished(arm, q, task)
    assert left < 1e-14
    assert np.abs(again - q).max() < 1e-10
    assert second_order(arm, q, task).rank < 6


@given(SEEDS, st.floats(-10, -6))
def test_error_covers_a_posture_that_is_not_quite_singular(seed, power):
    """A posture a little off the singular set has the class and, to the error stated, the eigenvalues of the one on it."""
    arm = random_arm(seed, 6)
    task = ks.find_task(arm, "full")
    second = second_order(arm, singular_posture(arm, task, seed), task)
    assume(clear(second))
    off = 10.0**power * np.random.default_rng(seed).normal(size=6)
    found = second_order(arm, second.q + off, task, tolerance=1e-4)
    assume(found.rank == second.rank)
    assert found.kind == second.kind
    assert np.abs(found.eigenvalues - second.eigenvalues).max() < 1e3 * 10.0**power


@given(SEEDS, st.sampled_from([2, 3, 4]))
def test_pencil_of_two_forms(seed, m):
    """The greatest λ_min(Q_w) over the circle, against a scan; never a wall and a passage at once."""
    rng = np.random.default_rng(seed)
    forms = rng.normal(size=(2, m, m)) + rng.choice([0.0, 2.0]) * np.eye(m)
    forms = (forms + forms.swapaxes(-1, -2)) / 2
    angles = np.linspace(0, 2 * PI, 1500, endpoint=False)
    w = np.stack([np.cos(angles), np.sin(angles)], -1)
    scan = np.linalg.eigvalsh(np.einsum("ti,iab->tab", w, forms))[:, 0].max()
    _, lower, upper = most_definite(forms, 1e-12)
    passing = passes(forms, 1e-12)
    assume(abs(scan) > 1e-3)
    if scan > 0:
        assert lower >= scan - 1e-9  # no direction of the scan is better, and the bound says that none at all is
        assert -1e-12 <= upper - lower < 1e-7
        assert not passing
    else:
        assert lower < 0
        assert passing  # two forms without a definite combination have a common zero (m > 2), or loop around it (m = 2)


@given(SEEDS)
def test_pencil_of_three_forms_with_a_wall(seed):
    """A definite combination is found however the basis of the three is chosen, and always the same one."""
    rng = np.random.default_rng(seed)
    forms = rng.normal(size=(3, 4, 4))
    forms = (forms + forms.swapaxes(-1, -2)) / 2
    forms[0] += 8 * np.eye(4)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    w, lower, upper = most_definite(forms, 1e-12)
    _, again, _ = most_definite(np.einsum("ij,jab->iab", turn, forms), 1e-12)
    assume(lower > 0.1)
    assert upper - lower < 1e-5
    assert abs(again - lower) < 1e-5
    assert np.linalg.eigvalsh(np.einsum("i,iab->ab", w, forms))[0] > 0


@given(SEEDS)
def test_general_arms_have_nothing_special(seed):
    """No relation among the axes of a general arm at a general posture."""
    arm = random_arm(seed, 6)
    assert axis_relations(arm, np.random.default_rng(seed).uniform(-PI, PI, 6)) == ()
