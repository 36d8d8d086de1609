"""The shell as a newcomer meets it: help, names that are nearly right, colour, the Tab key, a line that says it works."""

import io
import os
import re
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

import kinestatics as ks
from kinestatics.cli import app as shell, completion, main, progress as line, terminal

COMMAND = [sys.executable, "-m", "kinestatics"]
PLAIN = {key: value for key, value in os.environ.items() if key not in ("FORCE_COLOR", "CLICOLOR_FORCE", "NO_COLOR")}


def run(*arguments, **environment):
    """A command in a process of its own: (exit code, stdout, stderr)."""
    done = subprocess.run([*COMMAND, *arguments], capture_output=True, env=PLAIN | environment, check=False)
    return done.returncode, done.stdout.decode(), done.stderr.decode()


# ---- help ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("columns", ["60", "80", "200"])
def test_help_lists_every_command_in_a_line(columns):
    """Each with what it is for, within the columns of the terminal, and no wider than 80."""
    code, text, err = run("--help", COLUMNS=columns)
    assert (code, err) == (0, "")
    assert all(re.search(rf"^  {name} +\S", text, re.MULTILINE) for name in shell.COMMANDS)
    assert " ".join(shell.COMMANDS["analyze"].split()) in text
    assert max(map(len, text.splitlines())) <= min(int(columns), 80)


def test_every_command_of_the_table_is_there():
    """The table of commands and the modules say the same; each command explains itself and its options."""
    code = (
        "import sys; from kinestatics.cli import app; group = app.Commands(name='x'); "
        "print(*[group.get_command(None, name).name for name in app.COMMANDS]); "
        "print(*[found.name for found in app.app.registered_commands])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.splitlines()
    assert found[0].split() == list(shell.COMMANDS)
    assert sorted(found[1].split()) == sorted(shell.COMMANDS)
    modules = {path.stem for path in Path(shell.__file__).parent.glob("*.py") if "@app.command" in path.read_text("utf-8")}
    assert modules == set(shell.COMMANDS)


@pytest.mark.parametrize("arguments", [["--help"], ["analyze", "--help"], ["check", "-h"], []])
def test_help_loads_nothing_that_only_work_needs(arguments):
    """No NumPy, no rich, no validator, and of the commands only the one that is asked about."""
    code = (
        "import sys, atexit; sys.argv = ['kinestatics', *sys.argv[1:]]; "
        "atexit.register(lambda: print(*sys.modules, file=sys.stderr)); from kinestatics.cli import main; main()"
    )
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)
    loaded = set(done.stderr.split())
    assert not {"numpy", "rich", "pydantic", "sympy", "matplotlib"} & {name.partition(".")[0] for name in loaded}
    commands = {name.rpartition(".")[2] for name in loaded if name.startswith("kinestatics.cli.")} & set(shell.COMMANDS)
    assert commands == set(arguments[:1]) & set(shell.COMMANDS)


def cpu_seconds(cache, *arguments):
    """CPU time of a fresh interpreter that finds compiled modules in `cache`, as after the first run of a user."""
    resource = pytest.importorskip("resource", reason="CPU time of a child process")
    environment = PLAIN | {"PYTHONPYCACHEPREFIX": str(cache), "PYTHONDONTWRITEBYTECODE": ""}
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], check=True, capture_output=True, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_help_costs_little_more_than_its_library(tmp_path):
    """Help of the whole and of a command take less than 1.6 times the import of Typer: best of six, taken in turn."""
    asked = (("-c", "import typer"), ("-m", "kinestatics", "--help"), ("-m", "kinestatics", "analyze", "--help"))
    runs = [[cpu_seconds(tmp_path, *arguments) for arguments in asked] for _ in range(6)]
    library, whole, one = (min(column) for column in zip(*runs, strict=True))
    assert whole < 1.6 * library
    assert one < 1.6 * library


# ---- names ---------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["analyse", "ur5e"], ["No such command 'analyse'", "Did you mean 'analyze'?"]),
        (["singularity", "ur5e"], ["Did you mean 'singularities'?"]),
        (["frobnicate"], ["No such command 'frobnicate'", "Known: 'analyze'", "'doctor'"]),
        (["--versoin"], ["--version"]),
        (["check", "--strct", "x.urdf"], ["--strict"]),
        (["export", "ur5e", "--as", "latx"], ["KS395", "'latex'"]),
        (["export", "ur5e", "--quantity", "jacobain"], ["KS393", "'jacobian'"]),
        (["singularities", "ur5e", "--link", "forarm_link"], ["KS310", "'forearm_link'"]),
    ],
)
def test_what_is_nearly_right_is_named(capsys, monkeypatch, arguments, words):
    """Commands, options, links, quantities, languages: exit code 2 and the nearest name."""
    monkeypatch.setattr(sys, "argv", ["kinestatics", *arguments])
    with pytest.raises(SystemExit) as stopped:
        main()
    out, err = capsys.readouterr()
    assert (stopped.value.code, out) == (2, "")
    assert [word for word in words if word not in err] == []


# ---- terminals -----------------------------------------------------------------------------------------------------------


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("stream", "environment", "painted"),
    [
        (Terminal(), {"TERM": "xterm"}, True),
        (Terminal(), {"TERM": "xterm", "NO_COLOR": ""}, True),  # empty means unset, as no-color.org says
        (Terminal(), {"TERM": "xterm", "NO_COLOR": "1"}, False),
        (Terminal(), {"TERM": "dumb"}, False),
        (io.StringIO(), {"TERM": "xterm"}, False),
    ],
)
def test_colour_only_where_it_is_welcome(monkeypatch, stream, environment, painted):
    for name in ("TERM", "NO_COLOR"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert terminal.paint("word", "error", stream) == ("\x1b[1;31mword\x1b[0m" if painted else "word")


@pytest.mark.skipif(os.name == "nt", reason="needs a pseudo-terminal")
@pytest.mark.parametrize("environment", [{"TERM": "xterm"}, {"TERM": "xterm", "NO_COLOR": "1"}, {"TERM": "dumb"}])
def test_an_error_on_a_real_terminal(environment):
    """Painted on one that wants it, and the same letters on one that does not."""
    import pty

    ours, theirs = pty.openpty()
    process = subprocess.Popen([*COMMAND, "analyze", "ur5"], stderr=theirs, stdout=theirs, env=PLAIN | environment)
    os.close(theirs)
    shown = b""
    try:
        while chunk := os.read(ours, 4096):
            shown += chunk
    except OSError:  # what the end of a pseudo-terminal looks like on Linux
        pass
    finally:
        os.close(ours)
    assert process.wait() == 2
    text = shown.decode()
    assert ("\x1b[1;31merror KS312:\x1b[0m" in text) == ("NO_COLOR" not in environment and environment["TERM"] != "dumb")
    assert "error KS312: no file and no catalogue robot 'ur5'" in re.sub(r"\x1b\[[0-9;]*m", "", text)


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_listing_comes_out_in_every_encoding(encoding):
    """No traceback where a terminal lacks a letter."""
    environment = PLAIN | {"PYTHONIOENCODING": encoding}
    done = subprocess.run([*COMMAND, "jacobian", "planar_2r"], capture_output=True, env=environment, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"planar_2r" in done.stdout or b"tip" in done.stdout


# ---- the line of progress ------------------------------------------------------------------------------------------------


def test_a_job_that_says_nothing_is_seen_to_live(monkeypatch):
    """The line appears without a word of the job, counts seconds, and is gone at the end."""
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setattr(line, "_AFTER", 0.02)
    monkeypatch.setattr(line, "_EVERY", 0.0)
    monkeypatch.setattr(line, "_TICK", 0.01)
    with line.on_terminal("thinking"):
        time.sleep(0.3)
    shown = sys.stderr.getvalue()
    assert shown.count("thinking") >= 3
    assert re.search(r"thinking  0 s", shown)
    assert shown.split("\r")[-2].strip() == ""


def test_an_error_takes_the_line_away(monkeypatch):
    """What ends a job early leaves no line behind, and goes on."""
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setattr(line, "_AFTER", 0.0)
    monkeypatch.setattr(line, "_EVERY", 0.0)

    def divide():
        with line.on_terminal("thinking") as tell:
            tell("dividing", 0.5)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        divide()
    assert "dividing  50%" in sys.stderr.getvalue()
    assert sys.stderr.getvalue().split("\r")[-2].strip() == ""


# ---- the Tab key ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def offered(capsys, monkeypatch):
    """Returns what is offered for the last of some words, as `shell` would ask for it."""

    def ask(*words, kind="bash"):
        line = " ".join(["kinestatics", *words])
        environment = {
            "_KINESTATICS_COMPLETE": f"complete_{kind}",
            "COMP_WORDS": line,
            "COMP_CWORD": str(len(words)),
            "_TYPER_COMPLETE_ARGS": line,
            "_TYPER_COMPLETE_FISH_ACTION": "get-args",
            "_TYPER_COMPLETE_WORD_TO_COMPLETE": words[-1],
        }
        for name, value in environment.items():
            monkeypatch.setenv(name, value)
        monkeypatch.setattr(sys, "argv", ["kinestatics"])
        with pytest.raises(SystemExit) as stopped:
            main()
        out, err = capsys.readouterr()
        assert (stopped.value.code or 0, err) == (0, "")
        return out.split()

    return ask


def test_tab_offers_commands_and_options(offered):
    assert offered("sin") == ["singularities"]
    assert set(offered("")) == set(shell.COMMANDS)
    assert "--package-root" in offered("check", "--pa")


def test_tab_offers_robots_and_robot_files(offered, tmp_path, monkeypatch):
    """Catalogue names, robot files and folders beside them; folders alone and names with blanks are left to the shell."""
    monkeypatch.chdir(tmp_path)
    for name in ("umbrella.urdf", "unit.XML", "notes.txt", "two words.urdf", ".hidden.urdf"):
        (tmp_path / name).write_text("")
    for name in ("upper", "zoo"):
        (tmp_path / name).mkdir()
    (tmp_path / "upper" / "a.urdf").write_text("")
    assert offered("analyze", "u") == ["ur10e", "ur3e", "ur5e", "umbrella.urdf", "unit.XML", "upper/"]
    assert offered("check", "upper/") == ["upper/a.urdf"]
    for nothing in ("zo", "two", "nowhere/", "."):
        assert offered("analyze", nothing) == ([".hidden.urdf"] if nothing == "." else [])


def test_tab_offers_links_and_joints_of_the_robot_on_the_line(offered):
    arm = ks.load("ur5e")
    assert offered("analyze", "ur5e", "--tip", "") == list(arm.link_names)
    assert offered("jacobian", "ur5e", "--axes", "t") == ["tip", "tool0"]
    assert offered("analyze", "ur5e", "--hold", "el") == ["elbow_joint="]
    assert completion.link_values(SimpleNamespace(params={"robot": "ur5e"}, args=[]), "fo") == ["forearm_link="]
    assert offered("analyze", "ur5e", "--tip", "tool0", "--base", "fo") == ["forearm_link"]


def test_tab_never_speaks_of_errors(offered, tmp_path):
    """A file that is broken, missing or a MuJoCo model, no robot yet: nothing is offered, and nothing is said."""
    broken, model = tmp_path / "broken.urdf", tmp_path / "model.xml"
    broken.write_text("<robot name='x'><link name='a'/><link")
    model.write_text("<mujoco/>")
    for robot in (str(broken), str(model), str(tmp_path / "missing.urdf"), str(tmp_path), "nothing"):
        assert offered("analyze", robot, "--tip", "") == []
    assert offered("analyze", "--tip", "") == []


def test_tab_offers_no_names_that_a_shell_would_run(offered, tmp_path):
    """A link called $(reboot) is not offered; its neighbour is."""
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="r"><link name="foot"/><link name="$(reboot)"/><joint name="a;b" type="continuous">'
        '<parent link="foot"/><child link="$(reboot)"/></joint></robot>'
    )
    assert offered("analyze", str(path), "--tip", "") == ["foot"]
    assert offered("analyze", str(path), "--hold", "") == []


def test_tab_offers_words(offered):
    assert offered("analyze", "ur5e", "--at", "") == ["home", "zero", "random"]
    assert offered("export", "ur5e", "--as", "ma") == ["matlab"]
    assert offered("jacobian", "ur5e", "--convention", "mls") == ["mls.body", "mls.spatial"]


@pytest.mark.parametrize("kind", ["zsh", "fish", "powershell"])
def test_other_shells(offered, kind):
    """Each is offered the same in its own way of writing."""
    assert any("ur5e" in word for word in offered("analyze", "ur5", kind=kind))
