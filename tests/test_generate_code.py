"""generate_code: the code of every language does what the expression says; names are harmless; the check finds faults."""

import importlib.util
import json
import math
import re
import shutil
import subprocess
import sys

import numpy as np
import pytest

import kinestatics as ks
from kinestatics import closed_form, generate_code
from kinestatics.symbolic.code import LANGUAGES, by_definition, drawn, evaluated, generate, steps

sympy = pytest.importorskip("sympy")
pytest.importorskip("flint")

FORMS = {
    "planar jacobian": lambda: closed_form("jacobian", ks.load("planar_2r"), frame=ks.Frame()),
    "puma jacobian": lambda: closed_form("jacobian", ks.load("puma_560"), frame=ks.Frame(), lengths="symbols"),
    "panda middle jacobian": lambda: closed_form("jacobian", ks.load("panda")),
    "ur5e determinant": lambda: closed_form("determinant", ks.load("ur5e"), lengths="symbols"),
    "ur5e gravity": lambda: closed_form("gravity_torques", ks.load("ur5e")),
    "stanford acceleration": lambda: closed_form("acceleration", ks.load("stanford_arm")),
    "kr5 torques": lambda: closed_form("joint_torques", ks.load("kr5")),
    "scara pose": lambda: closed_form("pose", ks.load("scara"), point=(0.1, 0, 0.2)),
    "iiwa minors": lambda: closed_form("minors", ks.load("iiwa_14")),
}


def plain(x, values):
    """The expression in numbers by SymPy's own arithmetic, 30 digits."""
    entries = list(x.flat()) if hasattr(x, "shape") else [x]
    return np.array([float(sympy.N(entry.subs(values), 30)) if entry.free_symbols else float(entry) for entry in entries])


def arguments_of(form, values):
    """The numbers of the arguments, in the order of the function."""
    found = [np.array([values[x] for x in form.symbols["joints"]])]
    for kind in ("rates", "accelerations", "wrench"):
        if kind in form.symbols:
            found.append(np.array([values[x] for x in form.symbols[kind]]))
    return [*found, *(values[x] for x in form.symbols.get("parameters", ()))]


def loaded(source, name, tmp_path):
    """A module of generated Python, imported from a file as a user would."""
    path = tmp_path / f"{name}.py"
    path.write_text(source, encoding="utf-8")
    spec = importlib.util.spec_from_file_location(f"generated_{name}", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return getattr(module, name)


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS)
def test_numpy(form, tmp_path):
    """Equal to the expression and to the definition; batch axes first."""
    form = form()
    function = loaded(generate_code(form, "numpy", name="f"), "f", tmp_path)
    several = [drawn(form, seed) for seed in range(3)]
    alone = [function(*arguments_of(form, numbers.values)) for numbers in several]
    for found, numbers in zip(alone, several, strict=True):
        expected = by_definition(form, numbers)
        size = max(1.0, np.abs(expected).max())
        assert np.abs(found.ravel() - expected.ravel()).max() <= 1e-12 * size
        assert np.abs(found.ravel() - plain(form.expression, numbers.values)).max() <= 1e-13 * size
    stacked = [np.stack(parts) for parts in zip(*(arguments_of(form, n.values) for n in several), strict=True)]
    np.testing.assert_allclose(function(*stacked), np.stack(alone), rtol=0, atol=1e-15)
    assert function(stacked[0][:0], *[x[:0] for x in stacked[1:]]).shape == (0, *alone[0].shape)


def test_defaults_are_the_robots_own_lengths(tmp_path):
    """Lengths that were named need not be given."""
    arm = ks.load("puma_560")
    function = loaded(generate_code(closed_form("jacobian", arm, frame=ks.Frame(), lengths="symbols")), "jacobian", tmp_path)
    q = np.random.default_rng(1).normal(size=(4, 5, 6))
    np.testing.assert_allclose(function(q), ks.jacobian(arm, q).array, rtol=0, atol=1e-14)


def test_jax(tmp_path):
    """Under jit and with a gradient, in a process of its own that is set to double precision."""
    pytest.importorskip("jax")
    forms = {"f": FORMS["planar jacobian"](), "g": FORMS["ur5e determinant"](), "h": FORMS["stanford acceleration"]()}
    given = {}
    for name, form in forms.items():
        (tmp_path / f"{name}.py").write_text(generate_code(form, "jax", name=name), encoding="utf-8")
        given[name] = [np.asarray(x).tolist() for x in arguments_of(form, drawn(form).values)]
    script = (
        "import importlib, json, sys, jax; jax.config.update('jax_enable_x64', True); import jax.numpy as jnp\n"
        "found = {}\n"
        "for name, given in json.load(sys.stdin).items():\n"
        "    f = getattr(importlib.import_module(name), name)\n"
        "    given = [jnp.asarray(x) for x in given]\n"
        "    slopes = jax.jit(jax.grad(lambda q: f(q, *given[1:]).sum()))(given[0])\n"
        "    found[name] = [f(*given).ravel().tolist(), slopes.tolist()]\n"
        "print(json.dumps(found))"
    )
    command = [sys.executable, "-c", script]
    run = subprocess.run(command, input=json.dumps(given), capture_output=True, text=True, check=True, cwd=tmp_path)
    for name, (found, gradient) in json.loads(run.stdout).items():
        form, values = forms[name], drawn(forms[name]).values
        np.testing.assert_allclose(found, plain(form.expression, values), rtol=0, atol=1e-13)
        total = sum(form.expression) if hasattr(form.expression, "shape") else form.expression
        slopes = [float(sympy.diff(total, x).subs(values)) for x in form.symbols["joints"]]
        np.testing.assert_allclose(gradient, slopes, rtol=0, atol=1e-12)


def compiled(form, language, tmp_path):
    """The numbers that a compiled program prints, all warnings errors."""
    compiler = {"c": "gcc", "cpp": "g++"}[language]
    if shutil.which(compiler) is None:
        pytest.skip(f"no {compiler}")
    numbers = drawn(form)
    arguments = arguments_of(form, numbers.values)
    size = int(np.prod(getattr(form.expression, "shape", ())))
    single = not hasattr(form.expression, "shape")
    declared, words = [], []
    for k, value in enumerate(arguments):
        entries = ", ".join(map(repr, np.atleast_1d(value).tolist()))
        if np.ndim(value) == 0:
            words.append(repr(float(value)))
            continue
        kind = f"const double x{k}[] = " if language == "c" else f"const std::array<double, {len(value)}> x{k} = "
        declared.append(f"{kind}{{{entries}}};")
        words.append(f"x{k}")
    show = f'for (int i = 0; i < {size}; i++) printf("%.17g\\n", r[i]);'
    if single:
        call = f'printf("%.17g\\n", f({", ".join(words)}));'
    elif language == "c":
        call = f"double r[{size}]; f({', '.join([*words, 'r'])}); {show}"
    else:
        call = f"const auto r = f({', '.join(words)}); {show}"
    source = generate_code(form, language, name="f")
    body = "\n".join(["#include <stdio.h>", source, "int main(void) {", *declared, call, "return 0; }"])
    path = tmp_path / f"program.{language}"
    path.write_text(body, encoding="utf-8")
    strict = ["-std=c99" if language == "c" else "-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"]
    subprocess.run([compiler, *strict, str(path), "-o", str(tmp_path / "program"), "-lm"], check=True)
    run = subprocess.run([str(tmp_path / "program")], capture_output=True, text=True, check=True)
    return np.array([float(line) for line in run.stdout.split()]), plain(form.expression, numbers.values)


@pytest.mark.parametrize("language", ["c", "cpp"])
@pytest.mark.parametrize(
    "name", ["planar jacobian", "puma jacobian", "ur5e determinant", "ur5e gravity", "stanford acceleration"]
)
def test_compiled(name, language, tmp_path):
    """C99 and C++17 without a warning, to 1e-13."""
    found, expected = compiled(FORMS[name](), language, tmp_path)
    assert np.abs(found - expected).max() <= 1e-13 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("language", ["matlab", "octave"])
def test_matlab(language, tmp_path):
    """Read by a small interpreter of the few forms that occur; run by Octave where there is one."""
    form = FORMS["puma jacobian"]()
    numbers = drawn(form)
    source = generate_code(form, language, name="f")
    expected = plain(form.expression, numbers.values)
    found = interpreted(source, arguments_of(form, numbers.values))
    assert np.abs(found.ravel() - expected).max() <= 1e-13
    if shutil.which("octave") is None:
        return
    (tmp_path / "f.m").write_text(source, encoding="utf-8")
    words = ", ".join(str(np.asarray(x).tolist()) for x in arguments_of(form, numbers.values))
    run = subprocess.run(
        ["octave", "--eval", f"printf('%.17g\\n', f({words})')"], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    np.testing.assert_allclose([float(x) for x in run.stdout.split()], expected, rtol=0, atol=1e-13)


def interpreted(source, arguments):
    """The result of a generated MATLAB function: assignments of arithmetic, x(k) counted from 1."""
    head, *lines = source.splitlines()
    names = head[head.index("(") + 1 : head.index(")")].split(", ")
    assert lines[-1] == "end"
    known = dict(zip(names, arguments, strict=True)) | {
        "sin": math.sin,
        "cos": math.cos,
        "sqrt": math.sqrt,
        "zeros": np.zeros,
    }
    result = None
    for line in lines[:-1]:
        if line.startswith("%"):
            continue
        left, right = line.strip().rstrip(";").split(" = ")
        value = calculated(right, known)
        if left == "result":
            result = value
        elif left.startswith("result("):
            result[tuple(int(k) - 1 for k in left[7:-1].split(", "))] = value
        else:
            assert left.isidentifier()
            known[left] = value
    return result


def calculated(text, known):
    """Arithmetic of names and numbers, walked node by node."""
    import ast
    import operator

    kinds = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: pow}

    def walk(node):
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.Name):
            return known[node.id.removeprefix("_")]
        if isinstance(node, ast.BinOp):
            return kinds[type(node.op)](walk(node.left), walk(node.right))
        if isinstance(node, ast.UnaryOp):
            return -walk(node.operand)
        assert isinstance(node, ast.Call)
        function, values = known[node.func.id.removeprefix("_")], [walk(x) for x in node.args]
        if isinstance(function, np.ndarray):
            return function[values[0] - 1]
        return np.zeros(values) if function is np.zeros else function(*values)

    text = re.sub(r"(?<![\w.])[A-Za-z]", r"_\g<0>", text.replace("^", "**"))  # words of Python may be names
    return walk(ast.parse(text, mode="eval").body)


NAMES = [
    "I",
    "E",
    "beta",
    "lambda",
    "double",
    "for",
    "end",
    "np",
    "jnp",
    "q",
    "c1",
    "s2",
    "x0",
    "result",
    "pi",
    "e",
    "i",
    "sin",
    "class",
]


def awkward():
    """An expression whose symbols are all words that some language has taken."""
    symbols = sympy.symbols(" ".join([*NAMES, "q1", "q2"]))
    *parameters, q1, q2 = symbols
    total = sum((k + 1) * x for k, x in enumerate(parameters))
    return total * sympy.cos(q1) + sympy.sin(q1 + q2) * parameters[2] ** 2 - sympy.sqrt(parameters[1]) / parameters[
        0
    ], symbols


@pytest.mark.parametrize("language", LANGUAGES)
def test_awkward_names(language, tmp_path):
    """Renamed with an underscore, told in the header, and still right."""
    x, symbols = awkward()
    source = generate_code(x, language, name="f", arguments={s.name: s for s in symbols})
    values = {s: 0.3 + 0.1 * k for k, s in enumerate(symbols)}
    expected = float(sympy.N(x.subs(values)))
    if language in ("numpy", "matlab", "octave"):
        taken = {"numpy": ["lambda", "for", "np", "class"], "matlab": ["end", "for", "pi", "i"]}.get(language, ["end", "pi"])
        for word in taken:
            assert f"{word} is called {word}_" in source
    arguments = [values[s] for s in symbols]
    if language == "numpy":
        assert abs(loaded(source, "f", tmp_path)(*arguments) - expected) <= 1e-13 * abs(expected)
    elif language in ("matlab", "octave"):
        assert abs(interpreted(source, arguments) - expected) <= 1e-13 * abs(expected)
    elif language in ("c", "cpp") and shutil.which("g++"):
        call = ", ".join(map(repr, arguments))
        path = tmp_path / f"p.{language}"
        path.write_text(f'#include <stdio.h>\n{source}\nint main(void) {{ printf("%.17g", f({call})); return 0; }}')
        compiler = "gcc" if language == "c" else "g++"
        subprocess.run([compiler, "-Wall", "-Wextra", "-Werror", str(path), "-o", str(tmp_path / "p"), "-lm"], check=True)
        found = float(subprocess.run([str(tmp_path / "p")], capture_output=True, text=True, check=True).stdout)
        assert abs(found - expected) <= 1e-13 * abs(expected)


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_text_of_a_model_becomes_code(language, tmp_path):
    """Names of robots, links and symbols that try to end a comment or a string stay inside it."""
    evil = '*/ int x; """\n__import__("os") // % \\ end'
    a = sympy.Symbol(evil, real=True)
    arm = ks.from_dh([(a, 0, 0, 0)], convention="standard", name=evil, joint_names=[evil])
    form = closed_form("jacobian", arm)
    source = generate_code(form, language, name="f")
    assert source.count('"""') == (2 if language in ("numpy", "jax") else 0)
    assert source.count("*/") == (1 if language in ("c", "cpp") else 0)
    assert '"os"' not in source
    if language in ("matlab", "octave"):
        assert all(line.startswith("%") for line in source.splitlines() if "int x;" in line)
    if language == "numpy":
        value = loaded(source, "f", tmp_path)(np.zeros(1), 2.0)
        assert value.shape == (6, 1)
    if language == "c" and shutil.which("gcc"):
        (tmp_path / "f.c").write_text(source)
        subprocess.run(["gcc", "-Wall", "-Werror", "-c", str(tmp_path / "f.c"), "-o", str(tmp_path / "f.o")], check=True)


def test_other_inputs(tmp_path):
    """Expressions, matrices, arrays, a Jacobian at symbols; arguments in groups."""
    a, q1, q2 = sympy.symbols("a q1 q2")
    f = loaded(generate_code(a * sympy.cos(q1), name="f"), "f", tmp_path)
    assert f(2.0, 0.0) == 2.0
    f = loaded(generate_code(sympy.Matrix([[a, 1], [0, sympy.tan(q1) / a]]), name="g"), "g", tmp_path)
    np.testing.assert_allclose(f(2.0, 0.5), [[2, 1], [0, math.tan(0.5) / 2]])
    f = loaded(generate_code([q1**2, q2**-2, sympy.pi], name="h", arguments={"q": [q2, q1]}), "h", tmp_path)
    np.testing.assert_allclose(f([2.0, 3.0]), [9, 0.25, math.pi])
    arm = ks.load("planar_2r")
    J = ks.jacobian(ks.exact(arm), ks.joint_symbols(arm))
    f = loaded(generate_code(J), "jacobian", tmp_path)
    np.testing.assert_allclose(f([0.3, 0.4]), ks.jacobian(arm, [0.3, 0.4]).array, atol=1e-15)
    assert "rows vx, vy" in generate_code(J, "c")
    several = sympy.atan2(a, q1) + sympy.Abs(a) + sympy.exp(q1) * sympy.log(a) + a ** sympy.Rational(3, 2) + 2**q1
    f = loaded(generate_code(several, name="k"), "k", tmp_path)
    assert abs(f(0.5, 0.7) - float(several.subs({a: 0.5, q1: 0.7}))) < 1e-14


def test_sines_are_computed_once():
    """One call for each angle, however often it occurs."""
    source = generate_code(FORMS["puma jacobian"](), "numpy")
    for k in (0, 1, 3, 4):
        assert source.count(f"np.sin(q[..., {k}])") == 1
    assert source.count("np.sin(angle23)") == source.count("np.cos(angle23)") == 1
    assert (source.count("np.sin"), source.count("np.cos")) == (5, 5)


def test_header():
    """Shapes, units, row order, frame."""
    source = generate_code(FORMS["puma jacobian"](), "cpp")
    for words in ("rows vx, vy, vz, wx, wy, wz", "axes of base, at the origin of tip", "radians", "row by row", "q: (6)"):
        assert words in source


def test_the_check_finds_faults(monkeypatch):
    """A wrong step, and a form that is not the robot's, are refused."""
    form = FORMS["planar jacobian"]()
    good = steps.steps_of

    def wrong(program, names):
        found = good(program, names)
        return steps.Steps(found.assignments, (found.results[0] + sympy.Rational(1, 10**9), *found.results[1:]))

    monkeypatch.setattr(generate, "steps_of", wrong)
    with pytest.raises(ks.KinestaticsError, match="KS396"):
        generate_code(form)
    assert generate_code(form, check=False)
    monkeypatch.setattr(generate, "steps_of", good)
    from dataclasses import replace

    with pytest.raises(ks.KinestaticsError, match="KS396: the code differs from the numeric definition"):
        generate_code(replace(form, expression=2 * form.expression))


def test_errors():
    """What cannot be written, and why."""
    x, t = sympy.symbols("x t")
    q = sympy.Function("q")(t)
    for call, error, number in (
        (lambda: generate_code(x, "fortran"), ks.UnknownNameError, "KS395"),
        (lambda: generate_code(x, 3), ks.UnknownNameError, "KS395"),
        (lambda: generate_code(x, name="for"), ks.ConfigurationError, "KS395"),
        (lambda: generate_code(x, name="f(); g"), ks.ConfigurationError, "KS395"),
        (lambda: generate_code(x, name="f\n"), ks.ConfigurationError, "KS395"),
        (lambda: generate_code(q), ks.ArrayTypeError, "KS395"),
        (lambda: generate_code(sympy.gamma(x)), ks.ArrayTypeError, "KS395"),
        (lambda: generate_code(sympy.sign(x), "c"), ks.ArrayTypeError, "KS395"),
        (lambda: generate_code(x + t, arguments={"x": x}), ks.ConfigurationError, "KS395"),
        (lambda: generate_code(x, arguments={"x": x, "y": [x]}), ks.ConfigurationError, "KS395"),
        (lambda: generate_code(x, arguments={"x": 3}), ks.ConfigurationError, "KS395"),
        (lambda: generate_code("x"), ks.ArrayTypeError, "KS302"),
        (lambda: generate_code(object()), ks.ArrayTypeError, "KS302"),
        (lambda: generate_code(sympy.log(x - 5)), ks.KinestaticsError, "KS396"),
    ):
        with pytest.raises(error) as caught:
            call()
        assert caught.value.code == number
        assert caught.value.hint


def test_evaluated():
    """The check's own arithmetic is right."""
    x, y = sympy.symbols("x y")
    z = sympy.sqrt(3) * x**2 / 7 - sympy.cos(x + y) * sympy.tan(y) + sympy.pi - sympy.Rational(1, 3) + sympy.asin(x) ** 2
    values = {x: 0.3, y: 0.8}
    assert abs(evaluated(z, values) - float(sympy.N(z.subs(values), 30))) < 1e-15
