"""The house plan, executed: floors, one place for row order, no heavy imports, modules of readable size."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "src" / "kinestatics"

FLOORS = {
    "errors": 0,
    "frames": 1,
    "namespaces": 1,
    "extras": 1,
    "palette": 1,
    "progress": 1,
    "surfaces": 1,
    "conventions": 2,
    "spatial": 2,
    "model": 3,
    "quantities": 3,
    "robots": 4,
    "definition": 4,
    "_kernels": 4,
    "screws_in_words": 4,
    "kinematics": 5,
    "tasks": 6,
    "recognition": 6,
    "six_vectors": 6,
    "statics": 7,
    "symbolic": 7,
    "dexterity": 8,
    "singular_sets": 8,
    "inverse_velocity": 8,
    "evaluator": 8,
    "grasps": 8,
    "analysis": 9,
    "bodies": 9,
    "installation": 9,
    "skeleton": 9,
    "plots": 10,
    "scene": 10,
    "report": 11,
    "notebook": 12,
    "explorer": 12,
    "cli": 13,
    "__main__": 14,
    "__init__": 14,
}
MODULES = sorted(PACKAGE.rglob("*.py"))


def unit_of(path):
    """The floor's name: a top-level module, or the folder a module lies in."""
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def imports_of(path):
    """Every module of the package that `path` imports, anywhere in the file, as path parts below the package."""
    package = path.relative_to(PACKAGE).parts[:-1]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level:
            parts = list(package[: len(package) - node.level + 1]) + (node.module or "").split(".")
            parts = [part for part in parts if part]
            if parts:
                yield parts
            else:
                yield from ([alias.name] for alias in node.names)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            names = [node.module] if isinstance(node, ast.ImportFrom) else [alias.name for alias in node.names]
            yield from (name.split(".")[1:] for name in names if name and name.startswith("kinestatics."))


@pytest.mark.parametrize("path", MODULES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_imports_point_to_lower_floors(path):
    """A module imports strictly lower floors, or its own folder."""
    unit = unit_of(path)
    for parts in imports_of(path):
        if parts[0] == unit:
            continue
        assert parts[0] in FLOORS, f"{path.name} imports {'.'.join(parts)}, which has no floor"
        assert FLOORS[parts[0]] < FLOORS[unit], f"{path.name} imports upwards: {parts[0]}"


def test_every_module_has_a_floor():
    """Nothing lives in the house without a floor."""
    assert {unit_of(path) for path in MODULES} == set(FLOORS)


def test_row_order_is_known_in_one_file():
    """Slices such as [:3] and [3:] of six-vectors appear in spatial.py alone; poses are cut by split_pose."""
    allowed = {"spatial.py", "program.py"}
    pattern = re.compile(r"\[(\.\.\., )?(:3|3:|3:6|0:3)(, :)?\]")
    for path in MODULES:
        if path.name in allowed or "cli" in path.parts or "catalogue" in path.parts:
            continue
        lines = path.read_text(encoding="utf-8").splitlines()
        found = [line for line in lines if pattern.search(line) and ">>>" not in line]
        assert not found, f"{path.name}: {found}"


def run(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout


def test_import_is_light():
    """Importing the package imports no optional library, no console library and nothing heavy."""
    heavy = {"sympy", "mujoco", "jax", "torch", "scipy", "matplotlib", "rich", "typer", "xacro", "xml", "multiprocessing"}
    listing = "import sys, {}; print(*(name.partition('.')[0] for name in sys.modules))"
    ours, numpys = (set(run(listing.format(name)).split()) for name in ("kinestatics", "numpy"))
    assert not heavy & (ours - numpys)


def test_public_names_are_documented():
    """Every public function and class says what it is, and shows one example that runs."""
    import kinestatics as ks

    missing = []
    for name in ks.__all__:
        thing = getattr(ks, name)
        if not callable(thing) or (isinstance(thing, type) and issubclass(thing, Exception)):
            continue
        text = thing.__doc__ or ""
        if ">>>" not in text:
            missing.append(name)
    results = {"Acceleration", "Analysis", "Hessian", "JacobianRate", "Recognition", "Task"}  # shown where they are made
    assert set(missing) <= results


def test_no_dangerous_calls():
    """No pickle, eval, exec or network client in the package; the guard alone has a socket, to listen."""
    forbidden = {"eval", "exec", "compile", "__import__"}
    modules = {"pickle", "marshal", "shelve", "socket", "http", "requests", "urllib.request"}
    for path in MODULES:
        banned = modules - {"socket"} if path.parts[-2:] == ("scene", "guard.py") else modules
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                assert node.func.id not in forbidden, f"{path.name}:{node.lineno}"
            if isinstance(node, ast.Import):
                assert not {alias.name.partition(".")[0] for alias in node.names} & banned, path.name
            if isinstance(node, ast.ImportFrom) and not node.level:
                assert node.module not in banned, path.name
                assert (node.module or "").partition(".")[0] not in banned, path.name
