"""closed_form: short results, names, frames, what a person reads, errors."""

import json
import time

import numpy as np
import pytest

import kinestatics as ks
from kinestatics import ClosedForm, closed_form
from kinestatics.symbolic.chain import ExactChain
from kinestatics.symbolic.closed_form import QUANTITIES
from kinestatics.symbolic.code import by_definition, drawn, evaluated
from kinestatics.symbolic.ring import TrigonometricRing

sympy = pytest.importorskip("sympy")
pytest.importorskip("flint")


def symbols(names):
    return sympy.symbols(names, real=True)


def puma():
    """PUMA 560 in symbols (standard table; Corke)."""
    a2, a3, d3, d4 = symbols("a2 a3 d3 d4")
    quarter = sympy.pi / 2
    rows = [(0, quarter, 0, 0), (a2, 0, 0, 0), (a3, -quarter, d3, 0), (0, quarter, d4, 0), (0, -quarter, 0, 0), (0, 0, 0, 0)]
    return ks.from_dh(rows, convention="standard")


def test_planar_arm_as_note_004_prints_it():
    """l1, l2, and rates that are added before they are multiplied."""
    l1, l2 = symbols("l1 l2")
    arm = ks.from_dh([(l1, 0, 0, 0), (l2, 0, 0, 0)], convention="standard")
    form = closed_form("velocity", arm)
    q1, q2 = form.symbols["joints"]
    v1, v2 = form.symbols["rates"]
    expected = -l1 * v1 * sympy.sin(q1) - l2 * (v1 + v2) * sympy.sin(q1 + q2)
    assert form.expression[0] == expected
    assert form.symbols["parameters"] == (l1, l2)
    J = closed_form("jacobian", arm, frame=ks.Frame(), task="position").expression
    assert J[1, 0] == l1 * sympy.cos(q1) + l2 * sympy.cos(q1 + q2)
    assert closed_form("determinant", arm).expression == l1 * l2 * sympy.sin(q2)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("ur5e", "-a2*a3*(a2*cos(q2) + a3*cos(q2 + q3) - d5*sin(q2 + q3 + q4))*sin(q3)*sin(q5)"),
        ("puma_560", "a2*(a3*sin(q3) + d4*cos(q3))*(a2*cos(q2) + a3*cos(q2 + q3) - d4*sin(q2 + q3))*sin(q5)"),
        ("stanford_arm", "q3**2*sin(q2)*sin(q5)"),
        ("kr5", "-a2*(a3*sin(q3) + d4*cos(q3))*(a1 + a2*cos(q2) + a3*cos(q2 + q3) - d4*sin(q2 + q3))*sin(q5)"),
        ("irb_140", "-a2*d4*(a1 + a2*sin(q2) + d4*cos(q2 + q3))*sin(q5)*cos(q3)"),
        ("elbow_rrr", "-a2*a3*(a2*cos(q2) + a3*cos(q2 + q3))*sin(q3)"),
        ("scara", "a1*a2*sin(q2)"),
    ],
)
def test_determinants_of_books(name, expected):
    """Published factors, sign as this package's frames give it (tests/laws compare with numbers)."""
    form = closed_form("determinant", ks.load(name), lengths="symbols")
    assert str(form.expression) == expected
    product = sympy.Mul(*(x**times for x, times in form.factors))
    assert product == form.expression
    assert form.operations <= 25


def test_pumas_base_jacobian_is_short():
    """c1, s1 times sums of waves: not one entry is a wall of products."""
    form = closed_form("jacobian", puma(), frame=ks.Frame())
    q = form.symbols["joints"]
    a2, a3, _, d4 = symbols("a2 a3 d3 d4")
    reach = a2 * sympy.cos(q[1]) + a3 * sympy.cos(q[1] + q[2]) - d4 * sympy.sin(q[1] + q[2])
    assert form.expression[2, 1] == reach
    assert form.expression[0, 0].has(reach)
    assert form.operations <= 200
    middle = closed_form("jacobian", puma())
    assert middle.operations <= 60
    assert middle.frame == ks.Frame.body("link3")
    assert "link3" in middle.where


def test_seconds():
    """Each quantity in less than a second once everything is imported (one of three tries: the machine is shared)."""
    for name in ("puma_560", "ur5e", "panda"):
        arm = ks.load(name)
        quantities = ["pose", "jacobian", "velocity", "acceleration", "joint_torques", "minors"]
        quantities += ["gravity_torques"] * arm.has_masses + ["determinant"] * (arm.n == 6)
        for quantity in quantities:
            assert any(timed(quantity, arm) < 1.0 for _ in range(3)), (name, quantity)


def timed(quantity, arm):
    start = time.process_time()
    closed_form(quantity, arm)
    return time.process_time() - start


def test_gravity_in_symbols():
    """Note 000, "gravity compensation": masses at the middle of both links, gravity along -y."""
    a1, a2, m1, m2, g = symbols("a1 a2 m1 m2 g")
    arm = ks.from_dh(
        [(a1, 0, 0, 0), (a2, 0, 0, 0)],
        convention="standard",
        masses=[m1, m2],
        centers_of_mass=[(-a1 / 2, 0, 0), (-a2 / 2, 0, 0)],
    )
    form = closed_form("gravity_torques", arm, gravity=(0, -g, 0))
    q1, q2 = form.symbols["joints"]
    expected = m1 * g * a1 * sympy.cos(q1) / 2 + m2 * g * (a1 * sympy.cos(q1) + a2 * sympy.cos(q1 + q2) / 2)
    assert sympy.expand(form.expression[0] - expected) == 0
    assert sympy.expand(form.expression[1] - m2 * g * a2 * sympy.cos(q1 + q2) / 2) == 0
    assert set(form.symbols["parameters"]) == {a1, a2, m1, m2, g}


def test_given_rates_wrenches_and_points():
    """Numbers, symbols and a Wrench with its side; a point in symbols."""
    arm = ks.load("planar_2r")
    w, x, f = symbols("w x f")
    form = closed_form("velocity", arm, qd=(w, 0), point=(x, 0, 0))
    q1, q2 = form.symbols["joints"]
    expected = w * (sympy.cos(q1) + (x + 1) * sympy.cos(q1 + q2))
    assert sympy.expand(form.expression[1] - expected) == 0
    assert "rates" not in form.symbols
    assert set(form.symbols["parameters"]) == {w, x}
    assert "(x, 0, 0)" in form.where
    push = closed_form("joint_torques", arm, wrench=(0, f, 0, 0, 0, 0)).expression
    load = closed_form("joint_torques", arm, wrench=ks.Wrench.on_robot(force=(0, 1, 0))).expression
    assert sympy.expand(push.subs(f, 1) + load) == sympy.zeros(2, 1)
    with pytest.raises(ks.FrameMismatchError, match="KS330"):
        closed_form("joint_torques", arm, wrench=ks.Wrench.on_robot(force=(0, 1, 0), frame=ks.Frame.body("link1")))


def test_names_do_not_collide():
    """Parameters called like joints, rates, wrenches, cosines and constants of SymPy."""
    names = symbols("q1 qd1 c1 s2 I E fx")
    a, b, c, d, e, f, g = names
    arm = ks.from_dh([(a, 0, b, 0), (c, sympy.pi / 2, d, 0), (e, 0, f, g)], convention="standard", types="RRR")
    for quantity in ("pose", "jacobian", "velocity", "acceleration", "joint_torques", "determinant"):
        form = closed_form(quantity, arm, **({"task": "position"} if quantity == "determinant" else {}))
        assert str(form.symbols["joints"][0]) == "theta1"
        known = [x for several in form.symbols.values() for x in several]
        assert len({str(x) for x in known}) == len(known)
        assert form.expression.free_symbols <= set(known)
        numbers = drawn(form)
        matrix = hasattr(form.expression, "shape")
        found = [evaluated(x, numbers.values) for x in (form.expression if matrix else [form.expression])]
        np.testing.assert_allclose(found, by_definition(form, numbers).ravel(), rtol=0, atol=1e-12)
    assert "fx_" in map(str, closed_form("joint_torques", arm).symbols["wrench"])


def test_constant_angles():
    """A twist beta, and 45 and 55 degrees: roots and cosines, short."""
    beta = sympy.Symbol("beta", real=True)
    arm = ks.from_dh([(0, beta, 0, 0), (1, 0, 0, sympy.pi / 4)], convention="standard")
    T = closed_form("pose", arm)
    assert T.expression[2, 2] == sympy.cos(beta)
    assert beta in T.symbols["parameters"]
    tilted = ks.from_dh([(0.3, np.deg2rad(55), 0, 0), (0.2, np.deg2rad(110), 0, 0)], convention="standard")
    form = closed_form("pose", tilted)
    assert form.operations < 250  # powers of the cosine of 5 degrees would be thousands
    assert "cos(11*pi/36)" in str(form)


def test_lengths_as_symbols():
    """Names as in a table, equal lengths alike; the numbers are told."""
    form = closed_form("determinant", ks.load("ur5e"), lengths="symbols")
    assert {str(x): float(v) for x, v in form.values.items()} == {"a2": 0.425, "a3": 0.3922, "d5": 0.0997}
    assert "a2 = 0.425" in str(form)


def test_text_and_json():
    """Lines of 80 columns, plain data."""
    for quantity in ("pose", "jacobian", "acceleration", "gravity_torques", "determinant"):
        form = closed_form(quantity, ks.load("ur5e"))
        assert isinstance(form, ClosedForm)
        assert max(map(len, str(form).splitlines())) <= 80
        data = json.loads(json.dumps(form.to_dict()))
        assert data["operations"] == form.operations
        text = data["expression"]
        first = text if isinstance(text, str) else text[0][0]
        original = form.expression if isinstance(text, str) else form.expression[0, 0]
        names = {str(x): x for x in original.free_symbols}
        assert sympy.expand(sympy.sympify(first, locals=names) - original) == 0
    assert "all other entries are 0" in str(closed_form("jacobian", ks.load("planar_2r")))


def test_minors():
    """One for each set of columns left out; of a square task the determinant; of few columns, in the frame asked for."""
    form = closed_form("minors", ks.load("iiwa_14"))
    assert form.expression.shape == (7, 1)
    assert form.row_names[3] == "without q4"
    assert form.expression[3] == 0  # a theorem of S-R-S arms: without the elbow the rest is singular
    assert closed_form("minors", ks.load("scara")).expression.shape == (1, 1)
    assert closed_form("minors", ks.load("al5d")).frame is not None
    assert closed_form("determinant", ks.load("ur5e")).frame is None


def test_an_arm_without_joints():
    """A single fixed link: everything is constant."""
    arm = ks.from_dh([], convention="standard", tool=np.eye(4))
    assert closed_form("pose", arm).expression == sympy.eye(4)
    assert closed_form("jacobian", arm).expression.shape == (6, 0)


@pytest.mark.parametrize(
    ("options", "error", "code"),
    [
        (("jacobain",), ks.UnknownNameError, "KS393"),
        ((7,), ks.UnknownNameError, "KS393"),
        (("pose", "frame", ks.Frame()), ks.ConfigurationError, "KS393"),
        (("jacobian", "gravity", (0, 0, 1)), ks.ConfigurationError, "KS393"),
        (("jacobian", "lengths", "letters"), ks.ConfigurationError, "KS393"),
        (("determinant", "task", "full"), ks.ConfigurationError, "KS394"),
        (("jacobian", "frame", "base"), ks.ArrayTypeError, "KS302"),
        (("jacobian", "at", "nowhere"), ks.UnknownNameError, "KS310"),
        (("jacobian", "task", "vq"), ks.UnknownNameError, "KS318"),
        (("jacobian", "point", (0, 0)), ks.ConfigurationError, "KS303"),
        (("jacobian", "point", (0, 0, np.nan)), ks.ConfigurationError, "KS303"),
        (("velocity", "qd", (1,)), ks.ConfigurationError, "KS303"),
        (("joint_torques", "wrench", "down"), ks.ConfigurationError, "KS303"),
    ],
)
def test_errors(options, error, code):
    """What is wrong, and a hint."""
    quantity, *rest = options
    keywords = {rest[0]: rest[1]} if rest else {}
    with pytest.raises(error) as caught:
        closed_form(quantity, ks.load("planar_2r"), **keywords)
    assert caught.value.code == code
    assert caught.value.hint


def test_errors_of_robots():
    """No masses, a screw joint, no robot."""
    with pytest.raises(ks.MissingMassError, match="KS320"):
        closed_form("gravity_torques", ks.load("scara"))
    with pytest.raises(ks.ArrayTypeError, match="KS302"):
        closed_form("pose", "ur5e")
    helical = ks.from_screws([(0, 0, 0.1, 0, 0, 1)], np.eye(4))
    with pytest.raises(ks.ConfigurationError, match="KS391"):
        closed_form("jacobian", helical)


@pytest.mark.parametrize("first", ["continuous", "prismatic"])
def test_a_coordinate_that_turns_and_slides(first, tmp_path):
    """One coordinate for two kinds of joint is refused where the chain is made, whichever comes first."""
    kinds = [first, "prismatic" if first == "continuous" else "continuous"]
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    path = tmp_path / "mixed.urdf"
    path.write_text(
        f"""<robot name="mixed"><link name="a"/><link name="b"/><link name="c"/>
        <joint name="j" type="{kinds[0]}"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>{limit}</joint>
        <joint name="k" type="{kinds[1]}"><parent link="b"/><child link="c"/><origin xyz="0.5 0 0"/>
        <axis xyz="1 0 0"/>{limit}<mimic joint="j" multiplier="2"/></joint></robot>"""
    )
    arm = ks.load(str(path), tip="c")
    for call in (lambda: ExactChain.of(arm), lambda: closed_form("jacobian", arm), lambda: ks.singularities(arm)):
        with pytest.raises(ks.ConfigurationError, match="KS391: joint 'j' turns one joint and slides another"):
            call()


def test_whole_numbers_of_python_are_polynomials():
    """As SymPy's own are."""
    ring = TrigonometricRing((), ())
    assert [ring.read(k) for k in (-2, 0, 1)] == [ring.read(sympy.Integer(k)) for k in (-2, 0, 1)]
    assert TrigonometricRing((), ()).read(3) == 3


def test_no_simplification_anywhere(monkeypatch):
    """Polynomials are canonical: SymPy's simplify and trigsimp are never called."""

    def refuse(*_, **__):
        raise AssertionError("simplified")

    for name in ("simplify", "trigsimp", "nsimplify", "fu"):
        if name != "nsimplify":
            monkeypatch.setattr(sympy, name, refuse)
    for quantity in QUANTITIES:
        closed_form(quantity, ks.load("ur5e"))
