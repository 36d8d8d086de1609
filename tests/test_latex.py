"""to_latex and derivation: mathematics that LaTeX reads, no short name that misleads, steps that lead to the result."""

import re
import time

import numpy as np
import pytest

import kinestatics as ks
from kinestatics import closed_form, derivation, to_latex
from kinestatics.symbolic.closed_form import QUANTITIES
from kinestatics.symbolic.latex_names import symbol

sympy = pytest.importorskip("sympy")
pytest.importorskip("flint")

WORDS = (
    "alpha beta gamma theta lambda omega pi tau cos sin tan exp log sqrt frac dot ddot left right mathrm text begin end "
    "quad cdot hline infty partial times tfrac det sum backslash wedge sim arcsin arccos"
)
COMMANDS = set(WORDS.split())


def check_latex(text):
    """A small reader: braces, \\left and \\right, environments, columns of a row, known commands, one script at a time."""
    depth, sides, environments = 0, 0, []
    i = 0
    while i < len(text):
        c = text[i]
        if c == "\\":
            found = re.match(r"\\([A-Za-z]+|.)", text[i:], re.S)
            word = found[1]
            assert not word.isalpha() or word in COMMANDS, word
            sides += {"left": 1, "right": -1}.get(word, 0)
            assert sides >= 0
            if word in ("begin", "end"):
                name = re.match(r"\{(\w+)\}", text[i + len(word) + 1 :])[1]
                if word == "begin":
                    environments.append(name)
                else:
                    assert environments.pop() == name
            i += len(found[0])
            continue
        depth += {"{": 1, "}": -1}.get(c, 0)
        assert depth >= 0
        assert c not in "#%~"
        assert c != "&" or environments
        i += 1
    assert (depth, sides, environments) == (0, 0, [])
    assert not re.search(r"[_^]\{[^{}]*\}\s*[_^](?!\{)", text)
    assert not re.search(r"_\{[^{}]*\}_|\^\{[^{}]*\}\^", text)
    for body in re.findall(r"\\begin\{bmatrix\}\n(.*?)\n\\end\{bmatrix\}", text, re.S):
        assert len({row.count("&") for row in body.split("\\\\")}) == 1


def drawable(text):
    """matplotlib's own reader of mathematics, for what has no environments."""
    mathtext = pytest.importorskip("matplotlib.mathtext")
    mathtext.MathTextParser("path").parse(f"${text}$")


EXPRESSIONS = {
    "a2*cos(q1 + q2)": r"a_{2} c_{12}",
    "cos(q1 - q2)**2": "c_{1-2}^{2}",
    "sin(q3 + alpha)": r"\sin\left(\alpha + q_{3}\right)",
    "cos(2*q1)": r"\cos\left(2 q_{1}\right)",
    "-x*(y - 1)/2": r"-\frac{x \left(y - 1\right)}{2}",
    "(x + 1)**2/y": r"\frac{\left(x + 1\right)^{2}}{y}",
    "sqrt(3)*x/2": r"\frac{\sqrt{3} x}{2}",
    "17*x/40": "0.425 x",
    "x/3 - 1/3": r"\frac{x}{3} - \frac{1}{3}",
    "x**-2": r"\frac{1}{x^{2}}",
    "qd1**2": r"\dot{q}_{1}^{2}",
    "qdd12 + thetad3": r"\ddot{q}_{12} + \dot{\theta}_{3}",
    "fx + mz + wx": r"f_{x} + m_{z} + \omega_{x}",
    "cos(q9 + q10)": "c_{9,10}",
    "l_tool": r"l_{\mathrm{tool}}",
    "mass": r"\mathrm{mass}",
    "pi*x": r"\pi x",
    "0.000001*x": r"1 \cdot 10^{-6} x",
}


@pytest.mark.parametrize(("text", "expected"), EXPRESSIONS.items())
def test_expressions(text, expected):
    """As it is written by hand."""
    names = {"beta": sympy.Symbol("beta"), "I": sympy.Symbol("I")}
    found = to_latex(sympy.sympify(text, locals=names))
    assert found == expected
    check_latex(found)
    drawable(found)


def test_short_names_are_not_mistaken():
    """Where a length is called c1 or s23, the cosine keeps its long form; the others stay short."""
    c1, q1, q2 = sympy.symbols("c1 q1 q2")
    assert to_latex(c1 * sympy.cos(q1) * sympy.sin(q2)) == r"c_{1} s_{2} \cos\left(q_{1}\right)"
    assert to_latex(sympy.cos(q1), short=False) == r"\cos\left(q_{1}\right)"


@pytest.mark.parametrize(
    "name", ["a", "I", "E", "beta", "lambda", "x_", "a b", "_", "%$&#{}\\^~", "é1", "a__1", "d3", "q1_", "\n"]
)
def test_any_name_is_harmless(name):
    """Marks of LaTeX in a symbol's name do not act."""
    text = to_latex(sympy.Symbol(name) * 2)
    check_latex(text)
    if "&" not in name:  # which matplotlib does not know
        drawable(text)


def test_legend():
    """What the short names stand for, and the lengths."""
    form = closed_form("determinant", ks.load("planar_2r"), lengths="symbols")
    text = to_latex(form, legend=True)
    assert r"s_{2} = \sin\left(q_{2}\right)" in text
    assert "a_{1} = 1" in text
    assert to_latex(form) == "a_{1}^{2} s_{2}"
    check_latex(text)


def test_quantities_at_symbols_and_numbers():
    """Labelled tables; rounding noise is 0."""
    arm = ks.load("planar_2r")
    J = ks.jacobian(ks.exact(arm), ks.joint_symbols(arm))
    text = to_latex(J)
    assert r"v_{x} & -s_{1} c_{2} - s_{1} - s_{2} c_{1} &" in text
    assert r"\text{joint1} & \text{joint2}" in text
    check_latex(text)
    numbers = to_latex(ks.jacobian(arm, [0.0, np.pi / 2]))
    assert r"v_{x} & -1 & -1" in numbers
    assert r"v_{y} & 1 & 0" in numbers
    for x in (
        ks.pose(arm, [0, 0.5]),
        ks.Wrench.on_robot(force=(1, 2, 3)),
        ks.jacobian(arm, [0, 1]) @ [1, 2],
        np.eye(3),
        [1, 2.5],
        3,
    ):
        check_latex(to_latex(x))
    assert to_latex(0.5) == "0.5"
    assert to_latex(np.array([1e-9, np.inf, np.nan])).count("\\\\") == 2


@pytest.mark.parametrize("name", ["planar_2r", "puma_560", "stanford_arm", "panda", "planar_3r"])
def test_closed_forms(name):
    """Every quantity is LaTeX, quickly."""
    arm = ks.load(name)
    for quantity in QUANTITIES:
        try:
            form = closed_form(quantity, arm)
        except ks.KinestaticsError:
            continue
        start = time.process_time()
        text = to_latex(form)
        assert time.process_time() - start < 2.0
        check_latex(text)
        if not hasattr(form.expression, "shape"):
            drawable(text)


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("name", ["planar_2r", "ur5e"])
def test_derivations(name, quantity):
    """Text with equations; each display is LaTeX; the last one ends with the closed form itself."""
    form = closed_form(quantity, ks.load(name))
    text = to_latex(form, steps=True)
    displays = re.findall(r"\\\[\n(.*?)\n\\\]", text, re.S)
    assert len(displays) >= 4
    for display in displays:
        check_latex(display)
    assert displays[-1].endswith(to_latex(form)) or quantity == "minors"
    outside = re.sub(r"\\\[\n.*?\n\\\]", "", text, flags=re.S)
    assert outside.count("$") % 2 == 0
    check_latex(outside.replace("$", ""))


def test_a_derivation_says_what_it_does():
    """Axes, points, columns; half angles of a determinant; the potential of gravity; the recipe of accelerations."""
    text = derivation("jacobian", ks.load("planar_2r"), frame=ks.Frame(), lengths="symbols")
    assert r"z_{2} \times (p - p_{2})" in text
    assert r"T_{0,2} = T_{0,1} T_{1,2}" in text
    text = derivation("determinant", ks.load("puma_560"), lengths="symbols")
    assert r"-2 a_{3} t_{3} u_{3} + d_{4} t_{3}^{2} - d_{4} u_{3}^{2}" in text
    assert "the same in all axes" in text
    assert r"\frac{\partial U}{\partial q}" in derivation("gravity_torques", ks.load("ur5e"))
    assert r"\frac{\partial v}{\partial \dot{q}}" in derivation("acceleration", ks.load("planar_2r"))
    slides = derivation("jacobian", ks.load("stanford_arm"), frame=ks.Frame())
    assert r"z_{3} \\ 0" in slides


def test_errors():
    """No mathematics, a batch, steps of nothing."""
    for wrong in ("text", object(), ["a"], np.zeros((2, 2, 2)), ks.jacobian(ks.load("planar_2r"), np.zeros((3, 2)))):
        with pytest.raises(ks.ArrayTypeError, match="KS302"):
            to_latex(wrong)
    with pytest.raises(ks.ArrayTypeError, match="KS394"):
        to_latex(sympy.Symbol("a"), steps=True)


def test_symbols_of_all_kinds_are_told_apart():
    """No two of these print alike."""
    names = ["a2", "a", "qd1", "qdd1", "q1", "q1_", "theta1", "wx", "dwx", "dvx", "vx", "m1", "mx", "d1", "alpha_1", "alpha"]
    assert len({symbol(name) for name in names}) == len(names)
