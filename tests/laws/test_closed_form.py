"""Closed forms are the numeric definition: every quantity, arm, frame and point; random chains of right and other angles."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import kinestatics as ks
from kinestatics import closed_form, exact
from kinestatics.symbolic.code import evaluated
from strategies import Features, assert_close, random_pose

PLAIN = ("pose", "jacobian", "velocity", "acceleration", "joint_torques")
CHEAP = settings(max_examples=8, deadline=None)


def at_numbers(form, values):
    """The expression in numbers, in its shape."""
    expression, known = form.expression, {}
    if not hasattr(expression, "shape"):
        return np.array(evaluated(expression, values, known))
    return np.array([[evaluated(x, values, known) for x in row] for row in expression.tolist()])


def numeric(quantity, model, frame, q, qd, qdd, wrench, **options):
    """The quantity by the public functions, frame and all."""
    if quantity == "pose":
        return ks.pose(model, q, **options).array
    if quantity == "gravity_torques":
        return ks.gravity_torques(model, q)[:, None]
    J = ks.jacobian(model, q, frame=frame, **options)
    if quantity == "jacobian":
        return J.array
    if quantity == "velocity":
        return (J @ qd).array[:, None]
    if quantity == "acceleration":
        return ks.acceleration(model, q, qd, qdd, frame=frame, **options).array[:, None]
    return ks.joint_torques(J, ks.Wrench(wrench, J.frame, "environment"))[:, None]


def check(model, quantities=PLAIN, frame=None, seed=0, tolerance=1e-12, numbers=None, lengths="numbers", **options):
    """Each quantity at random numbers."""
    rng = np.random.default_rng(seed)
    forms = {}
    for quantity in quantities:
        given_frame = {} if frame is None or quantity in ("pose", "gravity_torques") else {"frame": frame}
        own = {} if quantity == "gravity_torques" else options
        form = forms[quantity] = closed_form(quantity, model, lengths=lengths, **given_frame, **own)
        if "frame" in given_frame:
            assert form.frame == ks.jacobian(model, np.zeros(model.n), **given_frame, **own).frame
        q, qd, qdd = rng.normal(size=(3, model.n))
        wrench = rng.normal(size=6)
        asked = form.question
        named = zip((*asked.qd, *asked.qdd, *asked.wrench), (*qd, *qdd, *wrench), strict=True)
        values = {**dict(zip(form.symbols["joints"], q, strict=True)), **dict(named), **(numbers or {})}
        values |= {x: float(v) for x, v in form.values.items()}
        robot = model if numbers is None else in_numbers(model, numbers)
        expected = numeric(quantity, robot, form.frame, q, qd, qdd, wrench, **own)
        assert_close(at_numbers(form, values), expected, tolerance)
    return forms


def in_numbers(model, numbers):
    """A model of symbols with numbers in their place."""
    replace = np.vectorize(lambda x: float(x.subs(numbers)) if hasattr(x, "subs") else float(x), otypes=[float])
    return model.map(lambda array: replace(array) if array.dtype == object and array.size else array.astype(float))


@pytest.mark.parametrize("name", ks.catalogue_names())
def test_every_catalogue_arm(name):
    """Numbers as they are, against the robot that is not exact."""
    arm = ks.load(name)
    quantities = ("pose", "jacobian", "acceleration", "joint_torques")
    check(arm, (*quantities, "gravity_torques") if arm.has_masses else quantities)
    check(arm, ("jacobian", "velocity"), lengths="symbols", seed=1)


@pytest.mark.parametrize("name", ["planar_2r", "puma_560", "scara", "stanford_arm"])
def test_every_frame_and_point(name):
    """Base, body, spatial and middle frames, the velocity of any point of any link, seen from any other."""
    arm = ks.load(name)
    middle = arm.link_name(arm.link_joints.index(arm.n // 2))
    for frame in (
        ks.Frame(),
        ks.Frame.body(),
        ks.Frame.spatial(),
        ks.Frame.body(middle),
        ks.Frame("tip", middle, (0.1, 0, 0)),
    ):
        check(arm, ("jacobian",), frame, seed=2)
    check(arm, ("pose", "jacobian", "acceleration"), point=(0.1, -0.2, 0.3), seed=3)
    check(arm, ("jacobian", "velocity"), ks.Frame("base", middle), at=middle, point=(0.0, 0.125, 0.3), seed=4)
    check(arm, ("jacobian",), ks.Frame.body("tip"), at=middle, seed=5)


def dh_chain(rng, n, angles, symbols=False):
    """A chain of turning and sliding joints with twists and offsets among some angles."""
    rows = []
    for k in range(n):
        a, d = rng.choice([0.0, 0.3, 0.75, -0.2], 2)
        row = [a, rng.choice(angles), d, rng.choice(angles)]
        if symbols:
            import sympy

            row[0] = sympy.Symbol(rng.choice(["a1", "c1", "s2", "I", "beta", "q3"]))
            row[1], row[3] = (sympy.nsimplify(x / np.pi, tolerance=1e-9) * sympy.pi for x in (row[1], row[3]))
            row[2] = sympy.Symbol("t1") * k
        rows.append(row)
    types = "".join(rng.choice(["R", "P"], n, p=[0.75, 0.25]))
    return ks.from_dh(rows, convention=str(rng.choice(["standard", "modified"])), types=types)


RIGHT = [0.0, np.pi / 2, -np.pi / 2, np.pi]
OTHER = [0.0, np.pi / 2, -np.pi / 2, np.pi / 4, -np.pi / 3, np.deg2rad(55), 0.3, np.pi / 12]


@given(st.integers(0, 2**31 - 1), st.integers(1, 6))
@CHEAP
def test_random_chains_of_right_angles(seed, n):
    """Standard and modified tables, turning and sliding joints."""
    rng = np.random.default_rng(seed)
    model = dh_chain(rng, n, RIGHT)
    frame = [None, ks.Frame(), ks.Frame.body(), ks.Frame.spatial()][seed % 4]
    check(model, frame=frame, seed=seed)


@given(st.integers(0, 2**31 - 1), st.integers(1, 3))
@settings(max_examples=5, deadline=None)
def test_random_chains_of_other_angles(seed, n):
    """Roots, whole degrees, and angles that are no part of a turn.

    Such angles are known to `exact` to 12 digits: its robot, in floats, is met to 1e-12, the one it was made of to 1e-11.
    """
    rng = np.random.default_rng(seed)
    model = dh_chain(rng, n, OTHER)
    quantities = PLAIN if n < 3 else ("pose", "jacobian")
    check(model, quantities, ks.Frame(), seed=seed, tolerance=1e-11)
    check(exact(model), quantities[:2], ks.Frame(), seed=seed, numbers={})


@given(st.integers(0, 2**31 - 1), st.integers(1, 4))
@CHEAP
def test_random_chains_of_symbols(seed, n):
    """Lengths whose names look like cosines, joints and constants."""
    rng = np.random.default_rng(seed)
    model = dh_chain(rng, n, RIGHT, symbols=True)
    symbols = sorted({x for row in model.placements.flat for x in getattr(row, "free_symbols", ())}, key=str)
    check(model, ("pose", "jacobian", "acceleration"), seed=seed, numbers={x: rng.uniform(0.2, 1.5) for x in symbols})


@given(st.integers(0, 2**31 - 1))
@settings(max_examples=8, deadline=None)
def test_trees(seed):
    """Links of one branch seen from another, and the gravity of all; the robot is the exact one, in floats."""
    model = exact(Features(seed=seed, joints=4, tree=True, right_angles=True, kinds=("revolute", "prismatic")).model())
    if model.n == 0:
        return
    if in_numbers(model, {}).has_masses:
        check(model, ("gravity_torques",), seed=seed, numbers={})
    link = model.link_names[seed % len(model.link_names)]
    check(model, ("jacobian", "acceleration"), ks.Frame(link, "tip"), seed=seed, numbers={})


def test_mimic_joints():
    """Columns of joints that share a coordinate are added, with their ratios."""
    text = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
    <joint name="j" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint>
    <joint name="k" type="continuous"><parent link="b"/><child link="c"/><origin xyz="0.5 0 0"/><axis xyz="0 0 1"/>
    <mimic joint="j" multiplier="-2" offset="0"/></joint>
    <link name="t"/>
    <joint name="f" type="fixed"><parent link="c"/><child link="t"/><origin xyz="0.25 0 0"/></joint></robot>"""
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "r.urdf"
        path.write_text(text)
        arm = ks.load(str(path), tip="t")
    check(arm, ("pose", "jacobian", "velocity", "acceleration"), ks.Frame())


@given(st.integers(0, 2**31 - 1))
@settings(max_examples=6, deadline=None)
def test_spatial_is_the_adjoint_of_body(seed):
    """J^s = Ad_g J^b, in polynomials: the difference is 0 in every entry."""
    import sympy

    rng = np.random.default_rng(seed)
    model = dh_chain(rng, 3, RIGHT, symbols=True)
    T = sympy.Matrix(closed_form("pose", model).expression)
    spatial, body = (closed_form("jacobian", model, frame=f).expression for f in (ks.Frame.spatial(), ks.Frame.body()))
    moved = ks.adjoint(np.array(T.tolist(), dtype=object)) @ np.array(body.tolist(), dtype=object)
    values = {x: float(rng.uniform(0.2, 1.5)) for x in T.free_symbols | spatial.free_symbols | body.free_symbols}
    difference = sympy.Matrix(moved) - spatial
    assert max(abs(evaluated(sympy.sympify(x), values)) for x in difference) <= 1e-12


def test_recipe_of_accelerations():
    """jacobian(v, q̇) q̈ + jacobian(v, q) q̇ by SymPy's own derivatives (note 004)."""
    for name in ("planar_2r", "stanford_arm"):
        arm = ks.load(name)
        v, a = (closed_form(x, arm) for x in ("velocity", "acceleration"))
        asked = a.question
        q = a.symbols["joints"]
        by_rates, by_joints = v.expression.jacobian(asked.qd), v.expression.jacobian(q)
        recipe = by_rates * column(asked.qdd) + by_joints * column(asked.qd)
        rng = np.random.default_rng(0)
        values = {x: float(rng.normal()) for x in (*q, *asked.qd, *asked.qdd)}
        known = {}
        found = [evaluated(x, values, known) for x in recipe]
        assert_close(found, [evaluated(x, values, known) for x in a.expression], 1e-12)


def column(symbols):
    """A SymPy column."""
    import sympy

    return sympy.Matrix(symbols)


@pytest.mark.parametrize("name", ks.catalogue_names())
def test_determinants(name):
    """The determinant of the arm's own task, sign and all; for other shapes every largest minor."""
    arm = ks.load(name)
    task = ks.find_task(arm)
    quantity = "determinant" if len(task.rows) == arm.n else "minors"
    form = closed_form(quantity, arm)
    rng = np.random.default_rng(7)
    for q in rng.normal(size=(20, arm.n)):
        J = ks.jacobian(arm, q).array[list(task.rows)]
        values = dict(zip(form.symbols["joints"], q, strict=True))
        if quantity == "determinant":
            assert_close(at_numbers(form, values), np.linalg.det(J), 1e-12)
            continue
        from itertools import combinations

        wide = J if arm.n >= len(J) else J.T
        minors = [[np.linalg.det(wide[:, kept])] for kept in combinations(range(wide.shape[1]), len(wide))]
        assert_close(at_numbers(form, values), minors, 1e-12)


def test_gravity_of_an_arm_at_any_angle():
    """A base at a general angle: three angles that are no part of a turn."""
    rng = np.random.default_rng(3)
    arm = ks.from_dh(
        [(0.3, 0.0, 0.1, 0.0), (0.2, np.pi / 2, 0.0, 0.0)],
        convention="standard",
        masses=[2.0, 1.5],
        centers_of_mass=[(0.1, 0.2, 0.3), (-0.1, 0.05, 0.0)],
        base=random_pose(rng),
    )
    check(exact(arm), ("pose", "jacobian", "gravity_torques"), seed=3, numbers={})
    check(arm, ("pose", "jacobian", "gravity_torques"), seed=3, tolerance=1e-11)
