"""Singular sets: the robots of golden/singular_robots.json, their traps, and what is said where nothing is known."""

import dataclasses
import itertools

import numpy as np
import pytest
import sympy

import kinestatics as ks
from kinestatics.singular_sets import singularities
from kinestatics.singular_sets.components import spectrum
from singular_robots import DATA, ROBOTS, expected, number, numeric, random_lengths, symbolic, task_of

SQUARE = [name for name, robot in ROBOTS.items() if robot.get("det")]
REDUNDANT = [name for name, robot in ROBOTS.items() if robot.get("rank_deficient_components")]


def values_at(expression, model, q, lengths):
    """A SymPy expression of the joints and lengths at configurations."""
    by_name = {str(s): s for s in expression.free_symbols}
    names = [f"q{k + 1}" for k in range(model.n)]
    arguments = [by_name.get(name, sympy.Symbol(name)) for name in (*names, *lengths)]
    return np.broadcast_to(sympy.lambdify(arguments, expression, "numpy")(*q.T, *lengths.values()), len(q))


def numeric_determinant(model, q, task):
    return np.linalg.det(ks.jacobian(model, q, check_finite=False).array[:, list(task.rows)])


@pytest.mark.parametrize("name", SQUARE)
def test_determinant_of_a_robot_of_symbols(name):
    """With symbols for lengths: the file's formula, and the determinant of NumPy, sign included, at two sets of lengths."""
    robot, rng = ROBOTS[name], np.random.default_rng(3)
    model = symbolic(robot)
    for lengths in (robot["params"], random_lengths(robot, rng)):
        arm = numeric(robot, lengths)
        found = singularities(
            model if model is not None else arm, task_of(robot), lengths=lengths if model is not None else "auto"
        )
        q = rng.uniform(-np.pi, np.pi, (1000, arm.n))
        known = lengths if model is not None else {str(s): float(v) for s, v in found.lengths.items()}
        values = values_at(found.determinant, arm, q, known)
        scale = max(np.abs(values).max(), 1e-300)
        assert np.abs(values - numeric_determinant(arm, q, found.task)).max() <= 1e-12 * scale
        assert np.abs(values - expected(robot["det"], lengths, q)).max() <= 1e-12 * scale


@pytest.mark.parametrize("name", SQUARE)
def test_factors_are_those_of_the_file(name):
    """As many components, real or void; each of the file's vanishes on one of ours and has its rank."""
    robot = ROBOTS[name]
    arm = numeric(robot)
    found = singularities(arm, task_of(robot))
    real = [c for c in robot["components"] if c["real_points_found"]]
    assert len(found.components) == len(real)
    assert sum(e.real is False for e, _ in found.factors) == len(robot["components"]) - len(real)
    for component in found.components:
        assert component.sound, component
        (match,) = [c for c in real if np.abs(expected(c["equations"][0], robot["params"], component.points)).max() < 1e-9]
        assert component.multiplicity == match["multiplicity"]
        assert component.rank == max(map(int, match["rank_at_generic_point"]))
        assert component.codimension == 1


@pytest.mark.parametrize("name", REDUNDANT)
def test_components_of_redundant_arms(name):
    """As many as in the file; each lies on one of the file's and loses rank."""
    robot = ROBOTS[name]
    found = singularities(numeric(robot), task_of(robot))
    assert found.complete
    assert len(found.components) == len(robot["rank_deficient_components"])
    for component in found.components:
        assert component.sound
        on = [
            max(np.abs(expected(text, robot["params"], component.points)).max() for text in equations)
            for equations in robot["rank_deficient_components"]
        ]
        assert min(on) < 1e-9, component


@pytest.mark.parametrize("name", REDUNDANT)
def test_components_at_other_lengths(name):
    """Nothing hangs on the lengths of known robots: sound, and no posture is missed."""
    robot = ROBOTS[name]
    arm = numeric(robot, random_lengths(robot, np.random.default_rng(5)))
    found = singularities(arm, task_of(robot))
    assert found.complete
    assert all(component.sound for component in found.components)
    minima = singular_postures(arm, found.task, 20)
    assert np.min([np.abs(c.residuals(minima)[0]).max(-1) for c in found.components], axis=0).max() < 1e-6


@pytest.mark.parametrize(
    "name", ["puma560", "ur5", "stanford_SHV", "kuka_kr5", "abb_irb140", "fanuc_crx10ia_l", "iiwa_SRS", "panda_FR3"]
)
def test_no_singular_posture_is_missed(name):
    """Least singular values minimised from random postures and polished: every minimum that is zero lies on a component."""
    robot = ROBOTS[name]
    arm = numeric(robot)
    found = singularities(arm, task_of(robot))
    minima = singular_postures(arm, found.task, 40)
    rest = np.min([np.abs(c.residuals(minima)[0]).max(-1) for c in found.components], axis=0)
    assert rest.max() < 1e-6


def singular_postures(arm, task, count):
    """Postures where rank is lost, found without any formula: descent on σ_min, then Newton steps on Jᵀw = 0, |w| = 1."""
    optimize = pytest.importorskip("scipy.optimize", reason="a judge of the dev extra")
    rows, rng, found = list(task.rows), np.random.default_rng(8), []

    def J(q):
        return ks.jacobian(arm, q, check_finite=False).array[rows]

    while len(found) < count:
        start = rng.uniform(-np.pi, np.pi, arm.n)
        descent = optimize.minimize(lambda q: np.linalg.svd(J(q), compute_uv=False)[-1] ** 2, start, method="BFGS")
        w = np.linalg.svd(J(descent.x))[0][:, -1]
        polished = optimize.least_squares(
            lambda y: np.r_[J(y[: arm.n]).T @ y[arm.n :], y[arm.n :] @ y[arm.n :] - 1.0],
            np.r_[descent.x, w], xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=200,
        )  # fmt: skip
        if np.linalg.svd(J(polished.x[: arm.n]), compute_uv=False)[-1] < 1e-10:
            found.append(polished.x[: arm.n])
    return np.array(found)


# Traps: section 1.1 of the study


def on_all(components, arm, seed=0):
    """A posture on several components at once."""
    q = np.random.default_rng(seed).uniform(-np.pi, np.pi, (200, arm.n))
    for _ in range(60):
        parts = [c.residuals(q) for c in components]
        values, slopes = np.concatenate([v for v, _ in parts], -1), np.concatenate([s for _, s in parts], -2)
        q = q - np.einsum("kij,kj->ki", np.linalg.pinv(slopes, rcond=1e-9), values)
    good = [np.abs(c.residuals(q)[0]).max(-1) < 1e-12 for c in components]
    return q[np.all(good, axis=0)][0]


@pytest.mark.parametrize(
    ("name", "pair", "rank"),
    [("puma560", (1, 2), 5), ("puma560", (0, 2), 5), ("anthropomorphic_6R", (0, 1), 4), ("ur5", (1, 2), None)],
)
def test_two_factors_zero_is_not_rank_four(name, pair, rank):
    """Components are ordered by their joints: shoulder (q2 q3), elbow (q3), wrist (q5)."""
    arm = numeric(ROBOTS[name])
    found = singularities(arm)
    posture = on_all([found.components[k] for k in pair], arm)
    sigma = spectrum(arm, posture, found.task, "tip")
    assert rank is None or (sigma > 1e-9).sum() == rank
    assert len(found.on(posture)) >= 2


def test_multiplicity_is_not_the_drop_of_rank():
    """q3² drops the rank by 1 in the Stanford arm and by 2 in the RRP arm."""
    stanford = singularities(numeric(ROBOTS["stanford_SHV"]))
    spherical = singularities(numeric(ROBOTS["spherical_RRP_notes000"]), "position")
    for found, drop in ((stanford, 1), (spherical, 2)):
        (component,) = [c for c in found.components if c.multiplicity == 2]
        assert found.task.rank - component.rank == drop


def test_a_factor_without_real_zeros_is_void():
    """d3 + d4 cos q3 of the orthogonal 3R: void for d4 < d3, an elbow for d4 > d3."""
    robot = ROBOTS["orthogonal_3R_cuspidal"]
    found = singularities(numeric(robot), "position")
    assert [e.real for e, _ in found.factors].count(False) == 1
    assert "void" in str(found)
    longer = singularities(numeric(robot, {**robot["params"], "d4": 2.5}), "position")
    assert all(e.real for e, _ in longer.factors)


@pytest.mark.parametrize(
    "names", list(itertools.pairwise(["c1", "s2", "q3", "t1", "I", "E", "beta", "S", "pi_", "u2", "g0"]))
)
def test_lengths_may_have_any_name(names):
    """Names that SymPy or the ring could take for something else."""
    a, b = (sympy.Symbol(name, positive=True) for name in names)
    arm = ks.from_dh([(0, sympy.pi / 2, 0, 0), (a, 0, 0, 0), (b, 0, 0, 0)], convention="standard")
    found = singularities(arm, "position")
    _, q2, q3 = ks.joint_symbols(arm)
    wanted = -a * b * sympy.sin(q3) * (a * sympy.cos(q2) + b * sympy.cos(q2 + q3))
    assert sympy.expand(sympy.expand_trig(found.determinant - wanted)) == 0


def test_special_lengths_factor_further():
    """An elbow arm of equal links: cos q2 + cos(q2 + q3) = 2 cos(q3/2) cos(q2 + q3/2)."""
    half = ks.from_dh([(0, np.pi / 2, 0, 0), (0.5, 0, 0, 0), (0.5, 0, 0, 0)], convention="standard")
    general = ks.from_dh([(0, np.pi / 2, 0, 0), (0.5, 0, 0, 0), (0.4, 0, 0, 0)], convention="standard")
    found, other = singularities(half, "position"), singularities(general, "position")
    assert sorted(m for _, m in found.factors) == [1, 1, 2]
    assert len(other.factors) == 2
    assert all(c.sound for c in found.components)


def test_angles_that_are_no_right_angles():
    """A twist of 55 degrees, a symbol for it, and 45 degrees with its roots: one determinant."""
    alpha = sympy.Symbol("alpha", real=True)

    def table(angle):
        return [(0.1, angle, 0.3, 0), (0.5, 0, 0, 0), (0.4, 0, 0.1, 0)]

    for angle in (55, 45, 60, 36):
        arm = ks.from_dh(table(np.radians(angle)), convention="standard")
        found = singularities(arm, "position")
        symbols = singularities(
            ks.from_dh(table(alpha), convention="standard"), "position", lengths={"alpha": np.radians(angle)}
        )
        q = np.random.default_rng(0).uniform(-3, 3, (50, 3))
        expected_values = numeric_determinant(arm, q, found.task)
        for result in (found, symbols):
            lengths = {str(s): float(v) for s, v in result.lengths.items()} | (
                {"alpha": np.radians(angle)} if result is symbols else {}
            )
            np.testing.assert_allclose(values_at(result.determinant, arm, q, lengths), expected_values, atol=1e-13)


def test_a_table_of_symbols_and_decimals():
    """A twist of 0.3 rad as a float beside a symbolic length: c² + s² is 1 all the same."""
    a = sympy.Symbol("a", positive=True)
    rows = [(0.1, 0.3, 0.2, 0.7), (a, 0, 0, 0), (0.4, 0.0, 0.1, 0)]
    found = singularities(ks.from_dh(rows, convention="standard"), "position", lengths={"a": 0.5})
    arm = ks.from_dh([(0.1, 0.3, 0.2, 0.7), (0.5, 0, 0, 0), (0.4, 0.0, 0.1, 0)], convention="standard")
    q = np.random.default_rng(0).uniform(-3, 3, (50, 3))
    values = values_at(found.determinant, arm, q, {"a": 0.5})
    np.testing.assert_allclose(values, numeric_determinant(arm, q, found.task), atol=1e-14)
    assert len(found.factors) == 2


def test_no_answer_is_not_none():
    """Symbols without numbers: whether a factor has real zeros is not decided, and the text says so."""
    a1, a2, a3, d2 = sympy.symbols("a1 a2 a3 d2", positive=True)
    right = sympy.pi / 2
    found = singularities(
        ks.from_dh([(a1, -right, 0, 0), (a2, right, d2, 0), (a3, 0, 0, 0)], convention="standard"), "position"
    )
    assert any(e.real is None for e, _ in found.factors)
    assert not found.never
    assert "not decided" in str(found)


def test_a_calibrated_robot_has_its_nominal_form():
    """A UR5 with noise of 1e-4 rad and m: at a tolerance of 0.01 three factors by name, and the residual."""
    rng = np.random.default_rng(0)
    lengths = ROBOTS["ur5"]["params"]
    rows = [
        [number(a, lengths), np.radians(alpha), number(d, lengths), np.radians(theta)]
        for a, alpha, d, theta in ROBOTS["ur5"]["dh"]["rows"]
    ]
    noisy = ks.from_dh(np.array(rows) + rng.normal(size=(6, 4)) * 1e-4, convention="standard")
    nominal = singularities(noisy, tolerance=0.01)
    assert [c.name for c in nominal.components] == ["shoulder", "elbow", "wrist"]
    assert 1e-5 < nominal.residual < 2e-3
    assert "nominal" in str(nominal)


def test_three_slides_at_right_angles_are_never_singular():
    """No angle at all: the determinant is a number."""
    half = np.pi / 2
    rows = [(0.0, half, 0.0, 0.0), (0.0, half, 0.0, half), (0.0, 0.0, 0.0, 0.0)]
    found = singularities(ks.from_dh(rows, convention="standard", types="PPP"), "position")
    assert found.never
    assert abs(found.determinant) == 1


@pytest.mark.parametrize(("name", "n"), [("three_joint_note_003", 3), ("cartesian", 3)])
def test_arms_that_are_never_singular(name, n):
    arm = ks.load(name) if name != "cartesian" else numeric(ROBOTS["cartesian_PPP"])
    found = singularities(arm)
    assert found.never
    assert arm.n == n
    assert "never singular" in str(found)


def test_results_print_and_are_data():
    """No line beyond 80 columns but for long words; JSON."""
    import json

    for name in ("puma_560", "panda", "iiwa_14", "al5d"):
        found = singularities(ks.load(name))
        assert all(len(line) <= 80 or " " not in line.strip() for line in str(found).splitlines())
        json.dumps(found.to_dict())


# Distances and certificates


def shortest_step(optimize, f, q, rng):
    """The length of the shortest step to f = 0, by sequential quadratic programming from 25 starts."""
    on_it = {"type": "eq", "fun": lambda x: f.value(q + x), "jac": lambda x: f.gradient(q + x)}
    options = {"ftol": 1e-15, "maxiter": 300}
    best = np.inf
    for _ in range(25):
        start = rng.normal(size=len(q)) * 0.7
        result = optimize.minimize(
            lambda x: x @ x, start, jac=lambda x: 2 * x, method="SLSQP", constraints=[on_it], options=options
        )
        if result.success and abs(f.value(q + result.x)) < 1e-9:
            best = min(best, float(np.sqrt(result.fun)))
    return best


@pytest.mark.parametrize("name", ["puma_560", "ur5e", "kr5"])
def test_distance_is_the_shortest(name):
    """Against a constrained minimisation from many starts; the bound is below it; the posture is singular."""
    optimize = pytest.importorskip("scipy.optimize", reason="a judge of the dev extra")
    arm, rng = ks.load(name), np.random.default_rng(0)
    found = singularities(arm)
    for q in arm.random_configurations(3, seed=1):
        for distance in found.distance(q):
            functions = [f for e in distance.component.equations for f in e.functions]
            best = min(shortest_step(optimize, f, q, rng) for f in functions)
            assert abs(distance.value - best) < 1e-6
            assert distance.at_least <= distance.value
            assert spectrum(arm, distance.nearest, found.task, "tip")[-1] < 1e-9


@pytest.mark.parametrize("name", ["puma_560", "ur5e", "kr5", "irb_140", "panda", "iiwa_14"])
def test_free_is_never_said_of_a_singular_box(name):
    """Boxes near components and elsewhere: "free" agrees with dense samples, "singular" has a witness inside."""
    arm, rng = ks.load(name), np.random.default_rng(2)
    found = singularities(arm)
    near = (
        np.concatenate([c.points[:6] for c in found.components]) + rng.normal(size=(6 * len(found.components), arm.n)) * 0.04
    )
    for centre in [*near, *rng.uniform(-np.pi, np.pi, (10, arm.n))]:
        result = found.certify_free((centre - 0.05, centre + 0.05))
        inside = centre + rng.uniform(-0.05, 0.05, (300, arm.n))
        if result.verdict == "free":
            for component in found.components:
                moved, solved = component.projected(inside, wrap=False)
                assert not np.any(solved & np.all(np.abs(moved - centre) <= 0.05, axis=-1))
        if result.verdict == "singular":
            assert np.all(np.abs(result.witness - centre) <= 0.05 + 1e-9)
            assert spectrum(found.model, result.witness, found.task, "tip")[-1] < 1e-9


def test_paths_are_certified_piece_by_piece():
    """Through the wrist singularity of the PUMA, and beside it."""
    found = singularities(ks.load("puma_560"))
    through = found.certify_free(path=[[0, 0.4, 0.5, 0.1, 0.3, 0.2], [0, 0.4, 0.5, 0.1, -0.3, 0.2]])
    beside = found.certify_free(
        path=[[0, 0.4, 0.5, 0.1, 0.3, 0.2], [0.5, 0.4, 0.6, 0.9, 0.4, 0.2], [0.5, 0.5, 0.6, 0.9, 0.5, 0.2]]
    )
    assert through.verdict == "singular"
    assert abs(through.witness[4]) < 1e-9
    assert beside.verdict == "free"


# Curves, cusps, aspects


def test_four_cusps_of_the_orthogonal_arm():
    """Section 3 of the study, and Wenger's count: four cusps on two closed curves; the two points on axis 1 are none."""
    found = singularities(numeric(ROBOTS["orthogonal_3R_cuspidal"]), "position")
    assert [curve.closed for curve in found.trace([1, 2])] == [True, True]
    cusps = found.cusps()
    listed = DATA["facts"]["cuspidal_3R"]["cusps_rho_z"]
    assert len(cusps) == len(listed) == 4
    for radius, height in listed:
        assert min(np.hypot(c.radius - radius, c.height - height) for c in cusps) < 0.02
    for cusp in cusps:
        assert cusp.residual < 1e-9
        assert spectrum(found.model, cusp.q, found.task, "tip")[-1] < 1e-12


@pytest.mark.parametrize(
    ("name", "count"), [("planar2R", 2), ("puma560", 8), ("ur5", 8), ("kuka_kr5", 8), ("orthogonal_3R_cuspidal", 2)]
)
def test_aspects(name, count):
    """The counts of section 3, from two seeds; representatives are regular and of both signs."""
    found = singularities(numeric(ROBOTS[name]), task_of(ROBOTS[name]))
    for seed in (0, 1):
        aspects = found.aspects(400, seed)
        assert aspects.count == count
        assert set(aspects.signs) == {-1, 1}
        assert spectrum(found.model, aspects.representatives, found.task, "tip")[:, -1].min() > 1e-3


@pytest.mark.slow
def test_aspects_of_an_arm_with_an_irreducible_determinant():
    """CRX-10iA/L: two regions, although a coarse grid shows eight."""
    found = singularities(numeric(ROBOTS["fanuc_crx10ia_l"]))
    assert found.aspects(800).count == 2


def test_curves_stay_on_their_component():
    """Steps are of the size asked for; both halves of a sine are found."""
    found = singularities(ks.load("ur5e"))
    curves = found.trace(["shoulder_lift_joint", "elbow_joint"], step=0.03)
    assert sum(curve.component.name == "elbow" for curve in curves) == 2
    for curve in curves:
        assert np.abs(curve.component.residuals(curve.points)[0]).max() < 1e-12
        assert np.linalg.norm(np.diff(curve.points, axis=0), axis=1).max() < 0.04
        assert curve.closed


# Cards


@pytest.mark.parametrize("case", DATA["lost_direction_cases"], ids=lambda c: f"{c['robot']} {c['case'].partition(' ')[0]}")
def test_lost_directions_of_the_file(case):
    """Rank, and the wrenches held for free: the line within 1e-8, the pitch within 1e-9 (the file has nine decimals)."""
    robot = ROBOTS[case["robot"]]
    arm = numeric(robot)
    found = singularities(arm, task_of(robot))
    card = found.at(case["q"], tolerance=1e-8)
    assert card.rank == case["rank"]
    assert len(card.free) == len(case["free_wrenches"])
    if len(card.free) != 1:
        return
    (mine,), (theirs,) = card.free, case["free_wrenches"]
    if theirs["kind"] == "couple":
        assert mine.kind == "couple"
        return
    direction = np.array(theirs["force_dir"])
    assert np.linalg.norm(np.cross(mine.direction, direction)) < 3e-8
    assert abs(mine.pitch - theirs["pitch"]) < 1e-8
    tip = ks.pose(arm, case["q"]).translation
    apart = np.cross(np.array(theirs["point_on_line"]) - (tip + mine.point), direction)
    assert np.linalg.norm(apart) < 1e-7


def test_a_card_in_words():
    """The straight arm of note 000: an elbow, a wall, and a load along it is held for free."""
    card = singularities(ks.load("planar_2r")).at([0.3, 0.0], boundary=True)
    assert card.is_singular
    assert card.on == ("elbow",)
    assert card.second_order.kind == "barrier"
    assert card.boundary.verdict == "boundary"
    text = str(card)
    assert "wall" in text
    assert "force along (0.9553, 0.2955, 0) in axes of base" in text
    assert max(map(len, text.splitlines())) <= 80
    regular = singularities(ks.load("planar_2r")).at([0.3, 1.0])
    assert not regular.is_singular
    assert regular.second_order is None
    assert np.isclose(regular.gain, 1 / ks.singular_values(ks.jacobian(ks.load("planar_2r"), [0.3, 1.0]))[-1])


# Found in review


def orthogonal(*rows):
    """An arm of three joints with axes at right angles: (a, alpha, d) of each row."""
    return ks.from_dh([(*row, 0.0) for row in rows], convention="standard")


def test_a_double_root_is_not_void():
    """sqrt(2) a2 - a3 sin q3 + a3 cos q3 with a2 = a3 touches zero at q3 = 135 degrees: floats alone say it does not."""
    a1, a2, a3, d2 = sympy.symbols("a1 a2 a3 d2", positive=True)
    right = sympy.pi / 2
    rows = [(a1, -right, 0, 0), (a2, right, d2, 0), (a3, 0, 0, right / 2)]
    lengths = {"a1": 1, "a2": 0.7, "a3": 0.7, "d2": 0.3}
    found = singularities(ks.from_dh(rows, convention="standard"), "position", lengths=lengths)
    q = np.array([0.3, 0.4, 0.75 * np.pi])
    assert spectrum(found.model, q, found.task, "tip")[-1] < 1e-12
    assert all(e.real is not False for e, _ in found.factors)
    assert found.certify_free((q - 0.01, q + 0.01)).verdict != "free"


def test_one_row_alone_can_be_lost():
    """The velocity along x of a planar arm: rank 0 where it is straight along x, whatever rounding is left there."""
    found = singularities(ks.load("planar_2r"), "vx")
    assert all(component.sound for component in found.components)
    for q in ([0.0, 0.0], [np.pi, 0.0], [0.0, np.pi]):
        assert found.at(q).is_singular
        assert found.at(q).rank == 0


@pytest.mark.parametrize("rows", [((0.87, -np.pi / 2, 0.0), (0.39, np.pi / 2, 1.43), (0.61, 0.0, 0.0))])
def test_cusps_do_not_hang_on_the_step(rows):
    """A factor of one joint has none: along it the kernel may lie in the curve everywhere."""
    found = singularities(orthogonal(*rows), "position")
    assert {len(found.cusps(step)) for step in (0.005, 0.02, 0.05)} == {2}


@pytest.mark.parametrize(
    ("rows", "count"),
    [
        (((0.59, -np.pi / 2, 0.0), (0.79, np.pi / 2, 0.37), (0.72, 0.0, 0.0)), 2),
        (((0.24, -np.pi / 2, 0.0), (0.9, np.pi / 2, 0.63), (1.22, 0.0, 0.0)), 5),
    ],
)
def test_aspects_are_those_of_a_flood_fill(rows, count):
    """Regions of one sign on a fine grid of the torus (q2, q3), joined over its edges, and ours from two seeds."""
    ndimage = pytest.importorskip("scipy.ndimage", reason="a judge of the dev extra")
    arm = orthogonal(*rows)
    found = singularities(arm, "position")
    size = 600
    axis = np.linspace(-np.pi, np.pi, size, endpoint=False) + 1e-3
    q = np.zeros((size, size, 3))
    q[..., 1], q[..., 2] = np.meshgrid(axis, axis, indexing="ij")
    sign = np.sign(numeric_determinant(arm, q.reshape(-1, 3), found.task)).reshape(size, size)
    regions = 0
    for side in (1, -1):
        tiled = np.tile(sign == side, (3, 3))
        labels, _ = ndimage.label(tiled)
        middle = labels[size : 2 * size, size : 2 * size]
        parents = {int(k): int(k) for k in np.unique(labels) if k}

        def root(k, parents=parents):
            while parents[k] != k:
                k = parents[k]
            return k

        for i, j in itertools.product(range(3), range(3)):
            tile = labels[i * size : (i + 1) * size, j * size : (j + 1) * size]
            for a, b in {(int(x), int(y)) for x, y in zip(middle.ravel(), tile.ravel(), strict=True) if x}:
                parents[max(root(a), root(b))] = min(root(a), root(b))
        regions += len({root(int(k)) for k in np.unique(middle) if k})
    assert regions == count
    assert [found.aspects(400, seed).count for seed in (0, 1)] == [count, count]


def test_what_is_of_the_nominal_robot_says_so():
    """A noisy arm at tolerance 0.01: certificate and card name the difference."""
    rng, lengths = np.random.default_rng(0), ROBOTS["ur5"]["params"]
    table = [
        [number(a, lengths), np.radians(b), number(d, lengths), np.radians(t)] for a, b, d, t in ROBOTS["ur5"]["dh"]["rows"]
    ]
    noisy = ks.from_dh(np.array(table) + rng.normal(size=(6, 4)) * 2e-3, convention="standard")
    found = singularities(noisy, tolerance=0.01)
    q = np.array([0.3, -0.9, 0.8, 0.5, 0.6, 0.2])
    assert "nominal" in str(found.certify_free((q - 0.01, q + 0.01)))
    assert "nominal" in str(found.at(q))


def test_symbols_without_numbers_have_no_distances():
    """Lengths that were drawn to find the structure are not shown as facts."""
    a1, a2 = sympy.symbols("a1 a2", positive=True)
    found = singularities(ks.from_dh([(a1, 0, 0, 0), (a2, 0, 0, 0)], convention="standard"))
    for call in (found.distance, found.at, lambda q: found.trace([0, 1], q), lambda q: found.certify_free((q, q))):
        with pytest.raises(ks.ConfigurationError, match="KS398"):
            call([0.1, 0.2])


def test_only_a_square_jacobian_has_a_determinant():
    """Two joints and three rows, of which one minor lives: no determinant is printed."""
    found = singularities(ks.load("planar_2r"), "position")
    assert found.determinant is None
    assert "det" not in str(found)
    assert [c.columns for c in found.components] == [(1,)]


def test_limits_count_or_not():
    """A joint that cannot be straight: its component is outside the limits, unless joints are taken to be free."""
    arm = dataclasses.replace(ks.load("planar_2r"), lower=np.array([-3.0, 0.1]), upper=np.array([3.0, 3.0]))
    assert [c.within_limits for c in singularities(arm).components] == [False]
    free = singularities(arm, limits=False)
    assert [c.within_limits for c in free.components] == [True]
    assert "limits" not in str(free)
    assert np.isfinite(arm.lower).all()


def test_what_ran_out_of_time_says_so():
    """A position task of a Panda in too little time: set, card and plain data say that there may be more."""
    found = singularities(ks.load("panda"), "position", budget=5)
    assert not found.complete
    assert not found.never
    assert "not complete" in str(found)
    assert found.to_dict()["complete"] is False
    card = found.at([0.1, 0.2, 0.3, -1.0, 0.4, 1.1, 0.2])
    assert "others may be nearer" in str(card).replace("\n         ", " ")
    assert card.to_dict()["complete"] is False


MISTAKES = {
    "a screw joint": (lambda: singularities(ks.from_screws([[0.1, 0, 0, 1, 0, 0]], order="linear-angular")), "KS391"),
    "unknown lengths": (lambda: singularities(ks.load("ur5e"), lengths="none"), "KS397"),
    "a value left out": (
        lambda: singularities(symbolic(ROBOTS["planar2R"]), ("vx", "vy"), lengths={"a1": 1}),
        "KS397.*a2",
    ),
    "a box upside down": (lambda: singularities(ks.load("kr5")).certify_free(([1] * 6, [0] * 6)), "KS303"),
    "neither box nor path": (lambda: singularities(ks.load("kr5")).certify_free(), "KS303"),
    "a posture of five": (lambda: singularities(ks.load("kr5")).distance([0] * 5), "KS303"),
    "no time at all": (lambda: singularities(ks.load("kr5"), budget=0), "KS353.*seconds"),
    "minors without time": (lambda: singularities(ks.load("iiwa_14"), budget=1e-9), "KS399.*larger budget"),
    "waves of a redundant arm": (lambda: singularities(ks.load("iiwa_14")).fourier, "KS398"),
    "angles that are neither": (lambda: ks.exact(ks.load("kr5"), angles="rational"), "KS303.*fractions"),
    "cusps where the first joint counts": (lambda: singularities(ks.load("elbow_rrr"), "vx,vz,wz").cusps(), "KS398"),
    "cusps of six joints": (lambda: singularities(ks.load("kr5")).cusps(), "KS398"),
    "aspects of a redundant arm": (lambda: singularities(ks.load("iiwa_14")).aspects(), "KS398"),
    "a trace of one joint": (lambda: singularities(ks.load("kr5")).trace(["joint_a1"]), "KS3"),
    "a tolerance of one": (lambda: ks.exact(ks.load("kr5"), 1.0), "KS353"),
    "an unknown task": (lambda: singularities(ks.load("kr5"), "wrist"), "KS318"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_are_named(mistake):
    call, message = MISTAKES[mistake]
    with pytest.raises(ks.KinestaticsError, match=f"(?s){message}"):
        call()
