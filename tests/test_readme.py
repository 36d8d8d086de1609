"""README.md, executed: its Python from top to bottom in one fresh namespace, and its commands in a shell."""

import contextlib
import importlib.metadata
import io
import re
import shlex
import shutil
import sys
from pathlib import Path

import pytest

import kinestatics as ks
from kinestatics.cli import main

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def blocks(language):
    """The fenced blocks of a language, each with the line it starts at."""
    found = re.finditer(rf"^```{language}\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    return [(TEXT[: match.start()].count("\n") + 2, match[1]) for match in found]


def commands():
    """The lines of the shell blocks that start with the name of the program, without their comments."""
    lines = [line.partition("  #")[0].strip() for _, block in blocks("sh") for line in block.splitlines()]
    stays = "kinestatics explore "  # until it is stopped: tests/test_cli_explore.py
    return [line for line in lines if line.startswith("kinestatics ") and not line.startswith(stays)]


def test_python_blocks_run_in_order():
    """Every Python block runs after those before it, without a warning, and its last results are what the comments say."""
    pytest.importorskip("sympy", reason="the README shows symbols")
    namespace, printed = {"__name__": "readme"}, io.StringIO()
    found = blocks("python")
    assert len(found) >= 3
    with contextlib.redirect_stdout(printed):
        for line, block in found:
            exec(compile("\n" * (line - 1) + block, "README.md", "exec"), namespace)
    assert namespace["J"].shape == (100_000, 6, 6)
    assert namespace["w"].shape == (100_000,)
    assert str(ks.analyze(ks.load("ur5e"))) in printed.getvalue()


def test_the_foreign_array_of_the_readme_is_recognised():
    """The README's which_convention line finds the convention it was written in."""
    arm = ks.load("ur5e")
    J = ks.jacobian(arm, arm.home)
    assert 'ks.which_convention(J.to_array(convention="drake"), arm, q)' in TEXT
    assert "drake" in ks.which_convention(J.to_array(convention="drake"), arm, arm.home).matches


@pytest.mark.parametrize("command", commands())
def test_commands_run(command, tmp_path, monkeypatch, capsys):
    """Every `kinestatics` line of the README is exit code 0, with the robot file it names at hand."""
    words = shlex.split(command)
    for name in (word for word in words if word.endswith(".urdf")):
        files = importlib.metadata.files("example-robot-data") or []
        source = next((Path(file.locate()) for file in files if str(file).endswith(f"/{name}")), None)
        if source is None:
            pytest.skip(f"{name} is in the package example-robot-data, which is part of the dev extra")
        shutil.copy(source, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", words)
    with pytest.raises(SystemExit) as stopped:
        main()
    out, err = capsys.readouterr()
    assert (stopped.value.code or 0, err) == (0, "")
    assert out.strip()


def test_there_are_commands_to_run():
    """The README shows all three commands."""
    assert {command.split()[1] for command in commands()} >= {"robots", "analyze", "jacobian"}


@pytest.mark.parametrize("link", sorted(set(re.findall(r"\]\(([^)#:]+)\)", TEXT))))
def test_links_lead_somewhere(link):
    """Every relative link of the README names a file or folder that is there."""
    assert (ROOT / link).exists()
