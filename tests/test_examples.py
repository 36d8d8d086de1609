"""The numbered examples run as a reader would run them, in order, and the list in examples/README.md is theirs."""

import ast
import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "examples"
EXAMPLES = sorted(FOLDER.glob("[0-9]*.py"))
SECONDS = 30.0  # each takes a few; a busy machine must not fail them
BLOCK = """
import importlib.util, sys
hidden = {"jax", "jaxlib", "torch", "sympy"}
class Hide:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in hidden:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, package=None: None if name in hidden else find(name, package)
sys.meta_path.insert(0, Hide())
import runpy
runpy.run_path(sys.argv[1], run_name="__main__")
"""


def run(*command, folder):
    """The finished process, with warnings as errors, in a folder that is not the project's."""
    environment = os.environ | {"PYTHONUTF8": "1", "JAX_PLATFORMS": "cpu"}
    return subprocess.run(
        [sys.executable, "-W", "error", *command],
        capture_output=True,
        encoding="utf-8",
        cwd=folder,
        env=environment,
        check=False,
    )


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_runs(path, tmp_path):
    """It ends well, says something, warns of nothing, leaves nothing behind, and does not take long."""
    before = os.times()
    done = run(str(path), folder=tmp_path)
    after = os.times()
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert len(done.stdout.splitlines()) >= 5
    assert list(tmp_path.iterdir()) == []
    assert after.children_user - before.children_user < SECONDS


@pytest.mark.parametrize("stem", ["04_your_own_arm", "08_jax_and_pytorch"])
def test_example_runs_without_optional_libraries(stem, tmp_path):
    """Where SymPy, JAX and PyTorch are missing, the example says so and goes on."""
    began = time.monotonic()
    done = run("-c", BLOCK, str(FOLDER / f"{stem}.py"), folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "not installed" in done.stdout
    assert time.monotonic() - began < 60


def test_every_example_is_listed_in_order():
    """examples/README.md lists each example once, in order, with the first line of its docstring as its question."""
    rows = re.findall(
        r"^\| \[(\d\d)\]\((.+?)\) \| (.+) \|$", (FOLDER / "README.md").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert [name for _, name, _ in rows] == [path.name for path in EXAMPLES]
    for number, (shown, name, question) in enumerate(rows, start=1):
        assert int(shown) == number == int(name[:2])
        docstring = ast.get_docstring(ast.parse((FOLDER / name).read_text(encoding="utf-8"))) or ""
        assert docstring.splitlines()[0] == question


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_example_teaches_a_law(path):
    """Its docstring states a law, its code asserts something, and it uses public names only."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text)
    assert "\nLaw: " in (ast.get_docstring(tree) or "")
    checks = [node for node in ast.walk(tree) if isinstance(node, ast.Assert)]
    checks += [node for node in ast.walk(tree) if isinstance(node, ast.Attribute) and node.attr.startswith("assert_")]
    assert len(checks) >= 2
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert not [n for n in imports if isinstance(n, ast.ImportFrom) and (n.module or "").startswith("kinestatics")]
