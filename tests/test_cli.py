"""The shell: every option, exit codes, strict JSON, and nothing but text on a bad day."""

import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kinestatics as ks
from kinestatics.cli import main
from kinestatics.cli.arguments import number, numbers

COMMAND = [sys.executable, "-m", "kinestatics"]
SHAREABLE = {key: value for key, value in os.environ.items() if key not in ("FORCE_COLOR", "CLICOLOR_FORCE")}


@pytest.fixture
def shell(capsys, monkeypatch):
    """Runs a command in this process: (exit code, stdout, stderr)."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["kinestatics", *arguments])
        with pytest.raises(SystemExit) as stopped:
            main()
        out, err = capsys.readouterr()
        return stopped.value.code or 0, out, err

    return run


@pytest.fixture
def done(shell):
    """Runs a command that must succeed without a word on stderr, and returns what it prints."""

    def run(*arguments):
        code, out, err = shell(*arguments)
        assert (code, err) == (0, "")
        return out

    return run


def strict(text):
    """JSON without NaN and Infinity."""

    def refuse(token):
        raise AssertionError(f"{token} is not JSON")

    return json.loads(text, parse_constant=refuse)


def urdf(tmp_path, name="arm", link="hand", joint="turn", limit='<limit lower="-1" upper="1" effort="5" velocity="1"/>'):
    """A file of one joint with these names."""
    path = tmp_path / "arm.urdf"
    path.write_text(
        f'<robot name="{name}"><link name="foot"/><link name="{link}"/><joint name="{joint}" type="revolute">'
        f'<parent link="foot"/><child link="{link}"/><origin xyz="0 0 1"/><axis xyz="0 0 1"/>{limit}</joint></robot>',
        encoding="utf-8",
    )
    return str(path)


def example(pattern):
    """A file of the package example-robot-data."""
    import importlib.metadata

    files = importlib.metadata.files("example-robot-data") or []
    return str(next(Path(file.locate()) for file in files if str(file).endswith(pattern)))


# ---- analyze -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ks.catalogue_names())
def test_analyze_prints_what_the_function_returns(done, name):
    """`kinestatics analyze NAME` is print(analyze(...)) at home, and --json its dictionary."""
    result = ks.analyze(ks.load(name), singularities=True)
    assert done("analyze", name) == f"{result}\n"
    assert strict(done("analyze", name, "--json")) == result.to_dict()
    plain = ks.analyze(ks.load(name))
    assert plain.near is None
    assert strict(done("analyze", name, "--json", "--no-singularities")) == plain.to_dict()


def test_configuration_words(done):
    """home, zero and random with a seed, which decides alone what random is."""
    arm = ks.load("ur5e")

    def q(*options):
        return strict(done("analyze", "ur5e", "--json", *options))["configuration"]

    assert q() == q("--at", "home") == arm.home.tolist()
    assert q("--at", "zero") == [0.0] * 6
    assert q("--at", "random") == q("--at", "random", "--seed", "0") == arm.random_configurations(1, 0)[0].tolist()
    assert q("--at", "random", "--seed", "7") == arm.random_configurations(1, 7)[0].tolist()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--at", "-0.1,0,0.2,0,0,0"], [-0.1, 0, 0.2, 0, 0, 0]),
        (["--at=-0.1,0,0.2,0,0,0"], [-0.1, 0, 0.2, 0, 0, 0]),
        (["--at", "-90deg, 30 deg, 0,0,0,0"], [math.radians(-90), math.radians(30), 0, 0, 0, 0]),
        (["--at", "0,-pi/2,pi/2,-pi/2,-3*pi/4,1e-3"], [0, -math.pi / 2, math.pi / 2, -math.pi / 2, -3 * math.pi / 4, 1e-3]),
        (["--at", "1 2 3 -1 -2 -3"], [1, 2, 3, -1, -2, -3]),
    ],
)
def test_configurations_in_numbers(done, arguments, expected):
    """Negative numbers with and without an equals sign, degrees, multiples of pi, commas or spaces."""
    assert strict(done("analyze", "ur5e", "--json", *arguments))["configuration"] == expected


@pytest.mark.parametrize("form", [["--load", "-1,2,-3"], ["--load=-1,2,-3"], ["--load", "-1,2,-3,0,0,0"]])
def test_load_is_minus_push(done, form):
    """A load on the robot needs the opposite torques of the same push by the robot, whichever way it is written."""
    load = strict(done("analyze", "ur5e", "--json", *form))
    push = strict(done("analyze", "ur5e", "--json", *[part.replace("--load", "--push") for part in form]))
    assert load["joint_torques"] == [-x for x in push["joint_torques"]]
    assert (load["wrench"]["acts_on"], push["wrench"]["acts_on"]) == ("robot", "environment")
    assert load["wrench"]["force"] == [-1, 2, -3]
    assert load["gravity_torques"] == push["gravity_torques"]


def test_a_moment_is_read_behind_the_force(done):
    """Six numbers are force and moment."""
    result = strict(done("analyze", "ur5e", "--json", "--push", "0,0,0,1,2,3"))
    expected = ks.joint_torques(
        ks.jacobian(ks.load("ur5e"), ks.load("ur5e").home), ks.Wrench.on_environment(torque=(1, 2, 3), frame=ks.Frame())
    )
    np.testing.assert_allclose(result["joint_torques"], expected, atol=1e-14)


def test_base_tip_and_task(done):
    """Another base, tip and rows reach the question; a link that is only called base by its file is link:base then."""
    result = strict(
        done("analyze", "ur5e", "--base", "wrist_3_link", "--tip", "base", "--task", "vx, wz", "--at", "zero", "--json")
    )
    assert (result["base"], result["tip"], result["task"]["rows"]) == ("wrist_3_link", "link:base", ["vx", "wz"])
    assert strict(done("analyze", "ur5e", "--task", "position", "--json"))["task"]["rows"] == ["vx", "vy", "vz"]
    assert strict(done("analyze", "ur5e", "--task", "vz", "--json"))["task"]["rows"] == ["vz"]


def test_a_real_urdf(done):
    """The Panda of example-robot-data: any link as tip, fingers held off the path, in text of 80 columns."""
    path = example("panda_description/urdf/panda.urdf")
    arguments = ("analyze", path, "--tip", "panda_hand_tcp", "--hold", "panda_finger_joint1=0.04", "--load", "0,0,-30")
    result = strict(done(*arguments, "--json"))
    assert len(result["joints"]) == 7
    assert result["tip"] == "panda_hand_tcp"
    assert result["gravity_torques"] is not None
    assert max(len(line) for line in done(*arguments).splitlines()) <= 80


# ---- jacobian and robots -------------------------------------------------------------------------------------------------


def test_jacobian_in_every_frame(done):
    """--axes, --origin and --convention write the array that the function writes; text and JSON agree."""
    arm = ks.load("ur5e")
    J = ks.jacobian(arm, arm.home)
    assert done("jacobian", "ur5e") == f"{J}\n"
    result = strict(done("jacobian", "ur5e", "--axes", "tip", "--origin", "forearm_link", "--json"))
    moved = J.change_frame(ks.Frame("tip", "forearm_link"))
    np.testing.assert_allclose(result["array"], moved.array, atol=1e-15)
    assert (result["axes"], result["origin"], result["rows"][0]) == ("tool0", "forearm_link", "vx")
    assert result["joints"] == list(arm.joint_names)


@pytest.mark.parametrize("convention", sorted(ks.CONVENTIONS))
def test_jacobian_in_every_convention(done, convention):
    """--convention is to_array(convention=...): exactly in JSON, to six decimals and without -0 in text."""
    arm = ks.load("ur5e")
    expected = ks.jacobian(arm, arm.home).to_array(convention=convention)
    result = strict(done("jacobian", "ur5e", "--convention", convention, "--json"))
    assert (result["convention"], np.array(result["array"]).shape) == (convention, expected.shape)
    np.testing.assert_array_equal(result["array"], expected)
    text = done("jacobian", "ur5e", "--convention", convention)
    printed = [float(x) for x in re.findall(r"-?\d+\.\d*", text)]
    np.testing.assert_allclose(printed, expected.ravel(), atol=6e-7)
    assert not re.search(r"-0\.(?!\d)", text)


def test_robots(done):
    """Every arm with its joints and its source, in 80 columns; the same in JSON."""
    text, entries = done("robots"), strict(done("robots", "--json"))
    assert [entry["name"] for entry in entries] == list(ks.catalogue_names())
    squeezed = " ".join(text.split())
    for entry in entries:
        assert re.search(rf"^{entry['name']} +{entry['joints']}  ", text, re.MULTILINE)
        assert entry["title"] in squeezed
        assert entry["source"] in squeezed
    assert max(len(line) for line in text.splitlines()) <= 80


# ---- help ----------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", [(), ("analyze",), ("jacobian",), ("robots",)])
def test_help(done, command):
    """--help and -h print the same 80 columns of usage for every command."""
    text = done(*command, "--help")
    assert text == done(*command, "-h")
    assert text.startswith("Usage: kinestatics")
    assert max(len(line) for line in text.splitlines()) <= 80
    assert "..." not in text.partition("Commands:")[2]


def test_version(done):
    """--version is the version of the package."""
    assert done("--version").strip() == ks.__version__


def test_singularities_prints_what_the_function_returns(done):
    """`kinestatics singularities NAME --at home` is the set and the card; --json both as data."""
    found = ks.singularities(ks.load("ur5e"))
    card = found.at(ks.load("ur5e").home)
    assert done("singularities", "ur5e", "--at", "home") == f"{found}\n\n{card}\n"
    data = strict(done("singularities", "ur5e", "--at", "home", "--at", "0,0,0,0,0,0", "--json"))
    assert data == {**found.to_dict(), "cards": [card.to_dict(), found.at([0.0] * 6).to_dict()]}
    assert "position" not in done("singularities", "puma_560", "--task", "position", "--link", "link4")


def test_an_arm_of_another_file_is_analysed_with_its_singularities(done, tmp_path):
    """An arm in MJCF."""
    path = tmp_path / "screw.xml"
    path.write_text(
        '<mujoco><worldbody><body><joint name="a" axis="0 0 1"/><geom size="0.1" mass="1"/>'
        '<body pos="1 0 0"><joint name="b" axis="0 0 1"/><geom size="0.1" mass="1"/></body></body></worldbody></mujoco>'
    )
    assert "no singularity was found" in done("analyze", str(path), "--singularities")


@pytest.mark.parametrize("quantity", ["pose", "jacobian", "velocity", "gravity_torques", "joint_torques", "determinant"])
def test_export_writes_every_quantity_in_every_language(done, quantity, tmp_path):
    """Text, LaTeX, derivation and code; to a file, and as JSON with the formula itself."""
    robot = "puma_560" if quantity != "gravity_torques" else "planar_2r"
    for language in ("text", "latex", "numpy", "c", "matlab"):
        assert done("export", robot, "--quantity", quantity, "--as", language, "--named").strip()
    path = tmp_path / "out.c"
    done("export", robot, "--quantity", quantity, "--as", "c", "--output", str(path))
    data = strict(done("export", robot, "--quantity", quantity, "--as", "c", "--json"))
    assert path.read_text(encoding="utf-8").rstrip() == data["text"].rstrip()


def test_export_in_frames(done, shell):
    """The geometric Jacobian is the default; other frames by their words; a wrong word is named."""
    form = ks.closed_form("jacobian", ks.load("ur5e"), frame=ks.Frame("base", "tip"))
    assert done("export", "ur5e") == f"{form}\n"
    assert "spatial" in done("export", "ur5e", "--frame", "spatial") or "origin of base" in done(
        "export", "ur5e", "--frame", "spatial"
    )
    code, _, err = shell("export", "ur5e", "--frame", "bodi")
    assert code == 2
    assert "KS393" in err
    code, _, err = shell("export", "ur5e", "--as", "fortran")
    assert code == 2
    assert "KS395" in err


def test_options_that_the_help_of_analyze_promises(done):
    """Every option that the help lists is tried in this file."""
    listed = set(re.findall(r"^ +(?:-h, )?(--[a-z-]+)", done("analyze", "--help"), re.MULTILINE))
    here = Path(__file__).read_text(encoding="utf-8")
    assert listed >= {"--base", "--tip", "--at", "--seed", "--load", "--push", "--task", "--hold", "--json"}
    assert all(f'"{option}' in here for option in listed)


def test_report_is_written_where_it_was_asked_for(shell, tmp_path):
    """--report writes the page and says so; --interactive and --scene make it larger; alone they are refused."""
    plain, rich = tmp_path / "plain.html", tmp_path / "rich.html"
    code, out, err = shell("analyze", "planar_2r", "--report", str(plain))
    assert (code, err) == (0, "")
    assert str(plain) in out
    assert plain.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    code, _, err = shell("analyze", "planar_2r", "--report", str(rich), "--interactive", "--scene")
    assert (code, err) == (0, "")
    assert rich.stat().st_size > 10 * plain.stat().st_size
    for option in ("--interactive", "--scene"):
        code, _, err = shell("analyze", "planar_2r", option)
        assert code == 2
        assert "KS414" in err


def test_payload_mount_and_several_loads(shell):
    """--payload, --mount and every --load and --push are those of the calls in Python."""
    loads = ["--load", "0,0,-30", "--load", "forearm_link=0,5,0,0,0,1", "--push", "1,0,0"]
    code, out, err = shell("analyze", "ur5e", *loads, "--payload", "2,0,0,0.1", "--mount", "wall", "--json")
    assert (code, err) == (0, "")
    found = strict(out)
    arm = ks.load("ur5e").with_payload(2.0, (0, 0, 0.1))
    asked = [
        ("tip", ks.Wrench.on_robot(force=(0, 0, -30))),
        ("forearm_link", ks.Wrench.on_robot(force=(0, 5, 0), torque=(0, 0, 1))),
        ("tip", ks.Wrench.on_environment(force=(1, 0, 0))),
    ]
    expected = ks.holding_torques(arm, arm.home, asked, gravity=ks.gravity_in_base("wall"))
    np.testing.assert_allclose(found["holding_torques"], expected, atol=1e-12)
    assert [load["link"] for load in found["loads"]] == ["tool0", "forearm_link", "tool0"]
    assert found["gravity"] == pytest.approx([9.81, 0, 0])
    code, out, _ = shell(
        "analyze", "ur5e", "--load", "0,0,-30", "--wrench-at", "forearm_link", "--mount", "0,pi,0", "--json"
    )
    assert strict(out)["loads"][0]["link"] == "forearm_link"
    assert strict(out)["gravity"] == pytest.approx([0, 0, 9.81])


def test_package_roots_and_xacro_options_are_passed_on(shell, tmp_path):
    """--package-root may be repeated; without --allow-xacro a xacro file is refused, and with it a wrong one still is."""
    code, _, err = shell("analyze", "ur5e", "--package-root", str(tmp_path), "--package-root", str(tmp_path))
    assert (code, err) == (0, "")
    code, _, err = shell("analyze", str(tmp_path / "missing.xacro"), "--allow-xacro")
    assert (code, "KS109" in err) == (2, True)


# ---- bad input -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["analyze"], ["Missing argument"]),
        (["analyse", "ur5e"], ["Did you mean 'analyze'"]),
        (["analyze", "ur5e", "--bse", "x"], ["--base"]),
        (["analyze", "ur5"], ["KS312", "'ur5e'"]),
        (["analyze", ""], ["KS312"]),
        (["analyze", "nowhere.urdf"], ["KS109"]),
        (["analyze", "ur5e", "--at", "hom"], ["KS342", "'home'"]),
        (["analyze", "ur5e", "--at", "1,2"], ["KS345", "2 numbers", "6 joints", "wrist_3_joint"]),
        (["analyze", "ur5e", "--at", ""], ["KS345", "0 numbers"]),
        (["analyze", "ur5e", "--at", "1,2,3,4,5,x"], ["KS340", "'x'"]),
        (["analyze", "ur5e", "--at", "1,2,3,4,5,"], ["KS340"]),
        (["analyze", "ur5e", "--at", "1,2,3,4,5,nan"], ["KS340"]),
        (["analyze", "ur5e", "--at", "1,2,3,4,5,1e999"], ["KS340", "not finite"]),
        (["analyze", "ur5e", "--at", "1,2,3,4,5,1/0"], ["KS340"]),
        (["analyze", "rrp_note_000", "--at", "0,0,1e300"], ["KS301", "KS308"]),
        (["analyze", "ur5e", "--at", "random", "--seed", "-1"], ["--seed"]),
        (["analyze", "ur5e", "--at", "random", "--seed", "x"], ["--seed"]),
        (["analyze", "ur5e", "--load", "1,2"], ["KS344", "--load has 2 numbers"]),
        (["analyze", "ur5e", "--push", "1,2,3,4"], ["KS344", "--push has 4 numbers"]),
        (["analyze", "ur5e", "--push", ""], ["KS344"]),
        (["analyze", "ur5e", "--load", "1,2,3N"], ["KS340"]),
        (["analyze", "ur5e", "--load", "0,0,1e200"], ["KS301"]),
        (["analyze", "ur5e", "--load", "=1,2,3"], ["KS344"]),
        (["analyze", "ur5e", "--load", "forearm=1,2,3"], ["KS310", "'forearm_link'"]),
        (["analyze", "ur5e", "--load", "1,2,3", "--wrench-at", "tool"], ["KS310", "'tool0'"]),
        (["analyze", "ur5e", "--payload", "1,2"], ["KS347", "--payload has 2 numbers"]),
        (["analyze", "ur5e", "--payload", "-1"], ["KS324", "positive"]),
        (["analyze", "ur5e", "--payload", "tool=1"], ["KS310", "'tool0'"]),
        (["analyze", "ur5e", "--mount", "roof"], ["KS322"]),
        (["analyze", "ur5e", "--mount", "1,2"], ["KS348", "--mount has 2 numbers"]),
        (["analyze", "ur5e", "--task", "speed"], ["KS318"]),
        (["analyze", "ur5e", "--task", "vx,vq"], ["KS318", "'vq'"]),
        (["analyze", "ur5e", "--base", "bse"], ["KS310", "'base'"]),
        (["analyze", "ur5e", "--tip", "tool"], ["KS310", "'tool0'"]),
        (["analyze", "ur5e", "--hold", "elbow"], ["KS341"]),
        (["analyze", "ur5e", "--hold", "=1"], ["KS341"]),
        (["analyze", "ur5e", "--hold", "elbo=1"], ["KS313"]),
        (["analyze", "ur5e", "--hold", "elbow_joint=x"], ["KS340", "--hold"]),
        (["analyze", "ur5e", "--hold", "elbow_joint="], ["KS341"]),
        (["analyze", "ur5e", "--hold", "elbow_joint=1,2"], ["KS341"]),
        (["analyze", "ur5e", "--payload", "1kg"], ["KS340", "--payload"]),
        (["jacobian", "ur5e", "--axes", "forarm_link"], ["KS310", "'forearm_link'"]),
        (["jacobian", "ur5e", "--origin", ""], ["KS310"]),
        (["jacobian", "ur5e", "--convention", "pinocchio.world"], ["KS315", "'pinocchio.WORLD'"]),
        (["jacobian", "ur5e", "--axes", "tip", "--convention", "pinocchio.WORLD"], ["KS319", "leave out"]),
        (["robots", "extra"], ["extra"]),
    ],
)
def test_bad_input_is_one_message_and_exit_code_2(shell, arguments, words):
    """A mistake is exit code 2, a message that names it and the remedy, nothing on stdout and never a traceback."""
    code, out, err = shell(*arguments)
    assert (code, out) == (2, "")
    assert "Traceback" not in err
    assert [word for word in words if word not in err] == []


def test_files_that_are_no_robots(shell, tmp_path):
    """A folder, an empty file, bytes, broken XML and a robot of several tips: exit code 2 and a message."""
    folder = tmp_path / "folder.urdf"
    folder.mkdir()
    contents = {"empty.urdf": b"", "bytes.urdf": bytes(range(256)), "broken.urdf": b"<robot name='x'><link"}
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    for path in [folder, *(tmp_path / name for name in contents), example("baxter_description/urdf/baxter.urdf")]:
        code, out, err = shell("analyze", str(path))
        assert (code, out, "Traceback" in err) == (2, "", False), path
        assert re.search(r"error KS\d{3}: ", err)


def test_large_angles_are_warned_of_once(shell):
    """An angle of a million turns works, with one warning on stderr and clean JSON on stdout."""
    code, out, err = shell("analyze", "ur5e", "--at", "1e7,0,0,0,0,0", "--json")
    assert code == 0
    assert strict(out)["configuration"][0] == 1e7
    assert err.count("KS308") == 1


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1.0),
        (" -pi/2 ", -math.pi / 2),
        ("30deg", math.radians(30)),
        ("90 deg", math.pi / 2),
        ("2*pi/3", 2 * math.pi / 3),
        ("1e-3", 1e-3),
        ("-(1+2)/4", -0.75),
        ("+0.5", 0.5),
    ],
)
def test_numbers_of_the_shell(text, value):
    """Decimals, pi, the four operations and degrees."""
    assert number(text) == value


@pytest.mark.parametrize(
    "text",
    [
        *("", "x", "deg", "1j", "True", "9**9", "9**9**9**9", "__import__('os')", "1;2", "1 2", "pi()", "'1'", "[1]"),
        *("1if 1else 2", "nan", "inf", "1<2", "1\n2", "\0"),
        *("9" * 6000, "(" * 500 + "1" + ")" * 500, "-" * 5000 + "1", "1" + "+1" * 5000),
    ],
    ids=lambda text: repr(text[:12]),
)
def test_what_is_no_number(text):
    """Everything else is KS340: nothing is executed, nothing hangs, nothing overflows the stack."""
    with pytest.raises(ks.ConfigurationError, match="KS340"):
        number(text)


def test_a_comma_missing_or_too_many():
    """With commas each part is a number of its own, so a forgotten or doubled comma is found."""
    assert numbers("1 2 3") == numbers("1,2,3") == numbers(" 1 , 2,3 ") == [1.0, 2.0, 3.0]
    for text in ("1,2 3", "1,,3", ",1", "1,"):
        with pytest.raises(ks.ConfigurationError, match="KS340"):
            numbers(text)


# ---- names from files ----------------------------------------------------------------------------------------------------


def test_hostile_names_cannot_drive_the_terminal(done, tmp_path):
    """Control and direction characters of a file's names are printed as escapes; markup stays what it is."""
    path = urdf(tmp_path, name="a&#127;[bold]b[/bold]", link="h&#x9b;31m", joint="j&#x202e;&#9;k")
    for command in ("analyze", "jacobian"):
        text = done(command, path)
        assert all(c == "\n" or c.isprintable() for c in text)
        assert "h\\x9b31m" in text
    assert "a\\x7f[bold]b[/bold]" in done("analyze", path)
    result = done("analyze", path, "--json")
    assert all(c == "\n" or 32 <= ord(c) < 127 for c in result)
    assert strict(result)["robot"] == "a\x7f[bold]b[/bold]"
    assert strict(result)["joints"] == ["j\u202e\tk"]


def test_a_line_break_in_a_name_forges_no_line(done, tmp_path):
    """A joint called "turn, line break, note: all is well" does not print a note."""
    path = urdf(tmp_path, joint="turn&#10;note: all is well")
    for command in ("analyze", "jacobian"):
        assert not [line for line in done(command, path).splitlines() if line.startswith("note: all")]
    assert strict(done("analyze", path, "--json"))["joints"] == ["turn\nnote: all is well"]


def test_hostile_arguments_are_printed_safely(shell):
    """A robot's name that holds an escape sequence comes back escaped in the error."""
    code, _, err = shell("analyze", "ur5e\x1b[31m")
    assert code == 2
    assert "\x1b" not in err


# ---- processes -----------------------------------------------------------------------------------------------------------


@pytest.mark.skipif(os.name == "nt", reason="needs sh and head")
def test_a_reader_that_leaves_early():
    """`kinestatics analyze ur5e | head -1`, and a reader that is gone at once, leave no traceback."""
    for reader in ("head -1", "true"):
        for command in ("analyze ur5e", "analyze ur5e --json", "robots"):
            line = f'"{sys.executable}" -m kinestatics {command} | {reader}'
            result = subprocess.run(["sh", "-c", line], capture_output=True, text=True, check=False)
            assert result.stderr == ""


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_a_full_disk_is_a_message():
    """Output that cannot be written is said in a line, and is no success."""
    with open("/dev/full", "w", encoding="utf-8") as full:
        result = subprocess.run([*COMMAND, "robots"], stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert result.returncode == 2
    assert result.stderr.startswith("error KS346")
    assert len(result.stderr.splitlines()) == 1


def test_plain_text_where_there_is_no_terminal():
    """Into a pipe goes plain text without colour codes, help and errors included."""
    for arguments in (["--help"], ["analyze", "ur5e"], ["robots"], ["analyze", "ur5"], ["analyze", "--bogus"]):
        result = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, env=SHAREABLE, check=False)
        assert "\x1b" not in result.stdout + result.stderr


def test_names_outside_the_encoding_of_the_terminal(tmp_path):
    """A terminal without a letter of a robot's name gets an escape, not a traceback; an ASCII one gets UTF-8."""
    path = urdf(tmp_path, name="Roboterarm für 1 kΩ")
    for encoding, expected in (("latin-1", b"Roboterarm f\xfcr 1 k\\u03a9: 1 joint"), ("ascii", "für 1 kΩ: 1".encode())):
        environment = SHAREABLE | {"PYTHONIOENCODING": encoding}
        result = subprocess.run([*COMMAND, "analyze", path], capture_output=True, env=environment, check=False)
        assert (result.returncode, result.stderr) == (0, b"")
        assert expected in result.stdout


def test_bytes_that_are_no_text_as_an_argument():
    """An argument that is not valid in the terminal's encoding is an error with a message."""
    result = subprocess.run([*COMMAND, "analyze", b"\xff\xfe"], capture_output=True, check=False)
    assert result.returncode == 2
    assert b"KS312" in result.stderr
    assert b"Traceback" not in result.stderr


def cpu_seconds(code):
    """CPU time of a fresh interpreter that runs `code`."""
    resource = pytest.importorskip("resource", reason="CPU time of a child process")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code], check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def test_importing_costs_less_than_numpy_does():
    """The package adds less to the start of a program than NumPy, which it needs: best of five, taken in turn."""
    runs = [[cpu_seconds(code) for code in ("pass", "import numpy", "import kinestatics")] for _ in range(5)]
    bare, with_numpy, with_package = (min(column) for column in zip(*runs, strict=True))
    assert with_package - with_numpy < with_numpy - bare


def test_the_commands_themselves_are_light():
    """Beside the package's own __init__, loading all commands imports neither NumPy nor rich: --help needs neither."""
    folder = str(Path(ks.__file__).parent)
    code = (
        "import sys, types; package = types.ModuleType('kinestatics'); package.__path__ = [sys.argv[1]]; "
        "sys.modules['kinestatics'] = package; from kinestatics.cli.app import COMMANDS, Commands; "
        "[Commands(name='x').get_command(None, name) for name in COMMANDS]; "
        "print(*sorted({'numpy', 'rich'} & set(sys.modules)))"
    )
    found = subprocess.run([sys.executable, "-c", code, folder], capture_output=True, text=True, check=True).stdout
    assert found.split() == []


def test_a_convention_says_axes_and_origin_itself(done):
    """--convention with --axes or --origin is refused, and the output says what the convention means."""
    text = done("jacobian", "ur5e", "--convention", "pinocchio.WORLD")
    assert text.splitlines()[0] == "pinocchio.WORLD: linear-angular rows, axes of base, at the origin of base, 6 x n"
    said = strict(done("jacobian", "ur5e", "--convention", "modern_robotics.body", "--json"))
    assert (said["order"], said["axes"], said["origin"]) == ("angular-linear", "tip", "tip")
