"""`doctor`: what is installed, and whether it works; broken things are found, absent ones are not called broken."""

import ast
import json
import re
import sys
import tomllib
from pathlib import Path

import pytest

import kinestatics as ks
from kinestatics import evaluator, extras, installation
from kinestatics.cli import main

PACKAGE = Path(ks.__file__).parent
NOT_EXTRAS = ("all", "test", "docs", "dev")


@pytest.fixture
def doctor(capsys, monkeypatch):
    """Runs the command: (exit code, stdout)."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["kinestatics", "doctor", *arguments])
        with pytest.raises(SystemExit) as stopped:
            main()
        out, err = capsys.readouterr()
        assert err == ""
        return stopped.value.code or 0, out

    return run


@pytest.fixture
def few_extras(monkeypatch):
    """Two extras only, so that not everything is imported."""
    chosen = [extra for extra in extras.EXTRAS if extra.name in ("qp", "xacro")]
    monkeypatch.setattr(installation, "EXTRAS", tuple(chosen))
    return chosen


# ---- the table of extras -------------------------------------------------------------------------------------------------


def test_the_table_is_that_of_the_project_file():
    """Names and packages of the extras, and the base, are those that pip installs."""
    with open(Path(__file__).parents[1] / "pyproject.toml", "rb") as file:
        project = tomllib.load(file)["project"]

    def names(requirements):
        return {re.match(r"[A-Za-z0-9._-]+", text)[0] for text in requirements}

    declared = {name: names(texts) for name, texts in project["optional-dependencies"].items() if name not in NOT_EXTRAS}
    assert {extra.name: set(extra.packages) for extra in extras.EXTRAS} == declared
    assert set(extras.BASE) <= names(project["dependencies"])


def test_every_missing_extra_is_one_of_the_table():
    """Wherever the package says "install this extra", the extra exists and brings the package."""
    known = {extra.name: extra.packages for extra in extras.EXTRAS}
    asked = set()
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "missing_extra":
                words = [argument.value for argument in node.args[:2] if isinstance(argument, ast.Constant)]
                if len(words) == 2:
                    asked.add(tuple(words))
    assert len(asked) >= 6
    assert [pair for pair in asked if pair[0] not in known.get(pair[1], ())] == []


@pytest.mark.parametrize(
    ("version", "bounds", "good"),
    [
        ("1.10", ">=1.9", True),
        ("1.9", ">=1.10", False),
        ("2", ">=2.0,<3", True),
        ("3.0.1", ">=2.0,<3", False),
        ("1.1.1", ">=1.1,<1.2", True),
        ("1.2.0", ">=1.1,<1.2", False),
        ("0.7", ">0.7", False),
        ("0.7.1", ">0.7", True),
        ("2.0rc1", ">=2.0", True),
        ("1.4", "==1.4.0", True),
        ("1.4", "!=1.4", True),  # kinds of bounds that are not looked at are taken as kept
        ("unknown", "", True),
    ],
)
def test_versions_within_bounds(version, bounds, good):
    assert extras.within(version, bounds) == good


# ---- the command ---------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("few_extras")
def test_a_sound_installation(doctor):
    """Exit code 0; the versions, the instruction sets, the self-test; the same in JSON."""
    code, text = doctor()
    assert code == 0
    for word in (ks.__version__, sys.version.split()[0], ks.kernels.instruction_set(), "agree with the definition", "ready"):
        assert word in text
    assert text.splitlines()[-1] == "nothing is broken"
    data = json.loads(doctor("--json")[1])
    assert data["faults"] == []
    assert data["kernels"]["offered"] == ks.kernels.instruction_sets()
    assert 0 <= data["kernels"]["difference"] < installation.TOLERANCE
    assert [extra["name"] for extra in data["extras"]] == ["xacro", "qp"]


def test_an_extra_that_is_not_installed_is_not_broken(doctor, monkeypatch):
    """It is called missing, with the command that installs it; exit code 0."""
    nothing = extras.Extra("qp", ("no-such-package-anywhere",), "nothing")
    monkeypatch.setattr(installation, "EXTRAS", (nothing,))
    code, text = doctor()
    assert code == 0
    assert "missing" in text
    assert "pip install 'kinestatics[qp]'" in text


def fake_package(folder, monkeypatch, version, source):
    """A package "brittle" of that version and source, installed in a folder."""
    (folder / "brittle.py").write_text(source)
    metadata = folder / f"brittle-{version}.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: brittle\nVersion: {version}\n")
    monkeypatch.syspath_prepend(folder)
    monkeypatch.delitem(sys.modules, "brittle", raising=False)
    monkeypatch.setattr(installation, "EXTRAS", (extras.Extra("view", ("brittle",), "nothing"),))


@pytest.mark.parametrize(
    ("version", "source", "word"),
    [
        ("1.0", "import os", "nothing is broken"),
        ("1.0", "raise OSError('libpango is not there')", "cannot be imported: OSError: libpango is not there"),
        ("1.0", "import no_such_module_of_brittle", "cannot be imported: ModuleNotFoundError"),
        ("0.9", "import os", "version 0.9 is installed; >=1.0 is needed"),
    ],
)
def test_an_extra_that_is_broken(doctor, monkeypatch, tmp_path, version, source, word):
    """A library that does not load, or is too old: exit code 1, and the reason."""
    fake_package(tmp_path, monkeypatch, version, source)
    monkeypatch.setattr(installation, "bounds_of", lambda name: ">=1.0" if name == "brittle" else "")
    code, text = doctor()
    assert word in text
    assert code == (0 if word == "nothing is broken" else 1)
    assert ("brittle" in text.splitlines()[-1]) == (code == 1)


@pytest.mark.usefixtures("few_extras")
def test_kernels_that_compute_wrongly_are_found(doctor, monkeypatch):
    """A kernel that is wrong in the ninth digit of one entry fails the self-test."""

    class Wrong(evaluator.Evaluator):
        def jacobian(self, q):
            J = super().jacobian(q)
            J[3, 2, 1] *= 1 + 1e-9
            return J

    monkeypatch.setattr(evaluator, "Evaluator", Wrong)
    code, text = doctor()
    assert code == 1
    assert re.search(r"broken: kernels: a Jacobian differs from the definition by \d", text)


@pytest.mark.usefixtures("few_extras")
def test_kernels_that_do_not_load_are_found(doctor, monkeypatch):
    def fail(name):
        raise ImportError(f"no kernel of {name}")

    monkeypatch.setattr(installation, "_difference", fail)
    code, text = doctor("--json")
    assert code == 1
    assert json.loads(text)["kernels"]["difference"] is None
    assert "ImportError: no kernel of" in json.loads(text)["faults"][0]


@pytest.mark.usefixtures("few_extras")
@pytest.mark.parametrize("columns", [60, 80])
def test_lines_fit_a_terminal(doctor, monkeypatch, columns):
    monkeypatch.setattr("kinestatics.cli.doctor.line_width", lambda: columns)
    assert max(len(line) for line in doctor()[1].splitlines() if "/" not in line) <= columns


@pytest.mark.slow
def test_everything_that_is_installed_here_works():
    """All extras of this environment load, and the kernels of every instruction set pass."""
    found = installation.examine()
    assert found.faults == ()
    assert found.kernels.checked == 64
