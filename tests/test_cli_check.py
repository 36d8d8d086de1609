"""`check`: what is wrong in a robot file, all of it, with its place; and nothing that is not wrong."""

import importlib.metadata
import json
import sys
import warnings
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings, strategies as st

import kinestatics as ks
from corpus import malformed
from kinestatics.cli import main
from kinestatics.errors import KinestaticsError
from kinestatics.robots.inspection import NOTES, REMEDIES, inspect_robot
from kinestatics.robots.recovery import find_faults

TEXTS = malformed()
LONG = ("deep_chain_5000.urdf", "many_children_3000.urdf")
SOUND = ("ok.urdf", "ok.xml", "unicode_name.urdf", "many_children_3000.urdf", "deep_bodies_100.xml")


@pytest.fixture
def check(capsys, monkeypatch):
    """Runs the command: (exit code, stdout); nothing goes to stderr."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["kinestatics", "check", *map(str, arguments)])
        with pytest.raises(SystemExit) as stopped:
            main()
        out, err = capsys.readouterr()
        assert err == ""
        return stopped.value.code or 0, out

    return run


def written(folder, name, text):
    path = folder / name
    path.write_bytes(text.encode("utf-16-le" if name.startswith("utf16") else "utf-8", "surrogateescape"))
    return path


def refusal(path):
    """The code with which `load` refuses a file, or None."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            ks.load(path, whole_tree=True)
        except KinestaticsError as error:
            return error.code
    return None


def example_robots():
    """The URDF files of the package example-robot-data."""
    files = importlib.metadata.files("example-robot-data") or []
    return sorted(Path(file.locate()) for file in files if str(file).endswith(".urdf"))


# ---- laws ----------------------------------------------------------------------------------------------------------------


def judge(tmp_path, name):
    """An error is found exactly where `load` refuses, and it is the same; every place is the beginning of a tag."""
    path = written(tmp_path, name, TEXTS[name])
    found = inspect_robot(path)
    errors = [remark.code for remark in found.remarks if remark.severity == "error"]
    refused = refusal(path)
    assert (refused in errors) if refused else not errors
    assert found.opened
    lines = TEXTS[name].split("\n")
    for remark in found.remarks:
        assert remark.place.file == str(path)
        if remark.place.line and remark.code > "KS112":
            assert lines[remark.place.line - 1][remark.place.column - 1] == "<"
    return found, refused


@pytest.mark.parametrize("name", [name for name in TEXTS if name.endswith(".urdf") and name not in LONG])
def test_an_error_is_what_load_refuses(tmp_path, name):
    found, refused = judge(tmp_path, name)
    assert not (name in SOUND and (refused or found.count("warning")))


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in TEXTS if name.endswith(".xml") or name in LONG])
def test_an_error_is_what_load_refuses_of_mujoco_models_and_long_files(tmp_path, name):
    found, refused = judge(tmp_path, name)
    assert not (name in SOUND and (refused or found.count("warning")))


@pytest.mark.parametrize("name", ["ok.xml", "nan_axis.xml", "range_rev.xml", "include_up.xml"])
def test_some_mujoco_models(tmp_path, name):
    judge(tmp_path, name)


@pytest.mark.parametrize("path", example_robots(), ids=lambda path: path.stem)
def test_real_robots(path):
    """An error where and only where `load` refuses; joints that cannot move are those of an independent reader."""
    found = inspect_robot(path)
    assert (found.count("error") > 0) == (refusal(path) is not None)
    if found.count("error"):
        return
    still = set()
    for joint in ElementTree.parse(path).getroot().findall("joint"):
        limit = joint.find("limit")
        if joint.get("type") not in ("revolute", "prismatic") or limit is None or joint.find("mimic") is not None:
            continue
        if float(limit.get("lower", 0)) == float(limit.get("upper", 0)):
            still.add(joint.get("name"))
    assert {r.message.split("'")[1] for r in found.remarks if r.code == "KS423"} == still


@pytest.mark.parametrize("name", ks.catalogue_names())
def test_the_catalogue_is_clean(name):
    assert inspect_robot(name).remarks == ()


def arm(parts):
    """Six joints in a row; `parts` replaces elements by (joint, word)."""
    lines = ['<robot name="six">', '<link name="l0"/>']
    for k in range(6):
        words = {
            "mass": '<mass value="1"/>',
            "inertia": '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>',
            "origin": '<origin xyz="0 0 0.2"/>',
            "axis": '<axis xyz="0 0 1"/>',
            "limit": '<limit lower="-1" upper="1" effort="5" velocity="1"/>',
            "extra": "",
        } | {word: text for (joint, word), text in parts.items() if joint == k}
        lines.append(f'<link name="l{k + 1}"><inertial>{words["mass"]}{words["inertia"]}</inertial></link>')
        lines.append(
            f'<joint name="j{k}" type="revolute"><!-- é -->{words["origin"]}<parent link="l{k}"/>'
            f'<child link="l{k + 1}"/>{words["axis"]}{words["limit"]}{words["extra"]}</joint>'
        )
    return "\n".join([*lines, "</robot>"])


FAULTS = {
    ("mass", '<mass value="-1"/>'): "KS160",
    ("mass", '<mass value="é"/>'): "KS145",
    ("mass", "<mass/>"): "KS125",
    ("inertia", '<inertia ixx="nan" iyy="1" izz="1"/>'): "KS146",
    ("origin", '<origin xyz="0 0"/>'): "KS144",
    ("origin", '<origin rpy="0 0 a>b"/>'): "KS145",
    ("axis", '<axis xyz="0 0 0"></axis>'): "KS142",
    ("axis", '<axis xyz="é 0 0"><!-- é --></axis>'): "KS145",
    ("limit", '<limit lower="2" upper="1" effort="5" velocity="1"/>'): "KS152",
    ("limit", '<limit lower="-1" upper="1" effort="-5" velocity="1"/>'): "KS153",
    ("extra", '<mimic joint="nobody"/>'): "KS170",
    ("extra", "<orgin/>"): "KS420",
    ("extra", '<axis xyz="1 0 0"/>'): "KS422",
}


WORDS = ("mass", "inertia", "origin", "axis", "limit", "extra")


@settings(max_examples=40)
@given(st.dictionaries(st.tuples(st.integers(0, 5), st.sampled_from(WORDS)), st.integers(0, 10), max_size=8))
def test_all_faults_are_found_and_no_others(chosen):
    """Faults at different elements are independent: each is found at its joint or link, and nothing else is."""
    kinds = {place: [(text, code) for (word, text), code in FAULTS.items() if word == place[1]] for place in chosen}
    parts = {place: kinds[place][pick % len(kinds[place])] for place, pick in chosen.items()}
    expected = sorted((joint, code) for (joint, _), (_, code) in parts.items())
    text = arm({place: text for place, (text, _) in parts.items()})
    found = find_faults(text.encode(), "arm.urdf")
    assert found.complete
    rows = [(error.place.line - 3) // 2 for error in found.errors]
    codes = [error.code for error in found.errors]
    assert sorted(zip(rows, codes, strict=True)) == [pair for pair in expected if pair[1] < "KS420"]
    assert found.findings == ()
    if all(word != "extra" for _, word in chosen):
        assert not [r for r in sorted(codes) if r.startswith("KS42")]


def test_the_remedy_of_every_warning():
    """Each code that a reader can warn with has a remedy, but for those that say it themselves."""
    sources = (Path(ks.__file__).parent / "robots").glob("*.py")
    warned = {
        text[:5]
        for source in sources
        for text in source.read_text(encoding="utf-8").split('Finding("')[1:]
        if text.startswith("KS")
    }
    assert warned - set(REMEDIES) <= {"KS108", "KS173", "KS174", "KS175", "KS176", "KS177", "KS178"}
    assert set(NOTES) <= warned


# ---- what is found -------------------------------------------------------------------------------------------------------


def codes(tmp_path, parts, kind="warning"):
    """Codes of that severity for the arm of six joints with these parts."""
    return [r.code for r in inspect_robot(written(tmp_path, "arm.urdf", arm(parts))).remarks if r.severity == kind]


@pytest.mark.parametrize(
    ("word", "wrong", "code", "right"),
    [
        ("extra", '<orgin xyz="0 0 1"/>', "KS420", "<dynamics/>"),
        ("extra", "<Axis/>", "KS420", "<hardwareInterface/>"),
        ("extra", '<mass value="1"/>', "KS420", "<calibration/>"),
        ("origin", '<origin xzy="0 0 1"/>', "KS421", '<origin xyz="0 0 1" note="1"/>'),
        ("limit", '<limit lower="-1" uper="1" effort="5" velocity="1"/>', "KS421",
         '<limit effort="5" velocity="1" lower="-1"/>'),
        ("extra", '<limit effort="1"/>', "KS422", "<calibration/>"),
        ("limit", '<limit effort="5" velocity="1"/>', "KS423", '<limit upper="0.1" effort="5" velocity="1"/>'),
        ("limit", '<limit lower="-180" upper="180" effort="5" velocity="1"/>', "KS424",
         '<limit lower="-12.5" upper="12.5" effort="5" velocity="1"/>'),
        ("limit", '<limit lower="-90" upper="90" effort="5" velocity="1"/>', "KS424",
         '<limit lower="-1e16" upper="1e16" effort="5" velocity="1"/>'),
        ("origin", '<origin xyz="0 0 333"/>', "KS425", '<origin xyz="0 0 12"/>'),
        ("mass", '<origin xyz="0 0 125"/><mass value="1"/>', "KS425", '<origin xyz="0 0 2"/><mass value="1"/>'),
        ("mass", '<mass value="35000"/>', "KS426", '<mass value="3500"/>'),
        ("inertia", '<inertia ixx="900" iyy="900" izz="900" ixy="0" ixz="0" iyz="0"/>', "KS426",
         '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>'),
        ("inertia", '<inertia ixx="1e-19" iyy="1e-19" izz="1e-19" ixy="0" ixz="0" iyz="0"/>', "KS426", ""),
    ],
)  # fmt: skip
def test_what_is_probably_a_mistake(tmp_path, word, wrong, code, right):
    """Found where it is, and not found in its sound neighbour."""
    assert code in codes(tmp_path, {(2, word): wrong})
    assert code not in codes(tmp_path, {(2, word): right})
    assert codes(tmp_path, {}) == []


def test_zero_outside_the_limits_is_a_note(tmp_path):
    limits = {(1, "limit"): '<limit lower="0.5" upper="1" effort="5" velocity="1"/>'}
    assert codes(tmp_path, limits, "note") == ["KS427"]
    assert codes(tmp_path, {}, "note") == []


def test_no_masses_at_all_are_said_once(tmp_path):
    """One missing mass is a warning at its link; when all are missing it is one warning."""
    none = {(k, "mass"): "" for k in range(6)}
    assert codes(tmp_path, {(3, "mass"): ""} | {(3, "inertia"): ""}) == ["KS161"]
    assert codes(tmp_path, none | {(k, "inertia"): "" for k in range(6)}) == ["KS428"]


def test_missing_meshes_say_where_they_were_looked_for(tmp_path):
    """A warning with the paths; none once the root is named."""
    mesh = '<visual><geometry><mesh filename="package://arm/hand.stl"/></geometry></visual>'
    path = written(tmp_path, "arm.urdf", TEXTS["ok.urdf"].replace("</inertial>", f"</inertial>{mesh}"))
    root = tmp_path / "roots"
    (root / "arm").mkdir(parents=True)
    found = inspect_robot(path, package_roots=[root])
    assert [remark.code for remark in found.remarks] == ["KS180"]
    assert str(root / "arm" / "hand.stl") in found.remarks[0].message
    (root / "arm" / "hand.stl").write_bytes(b"")
    assert inspect_robot(path, package_roots=[root]).remarks == ()


def test_a_base_that_is_no_link(tmp_path):
    found = inspect_robot(written(tmp_path, "arm.urdf", arm({})), base="l9")
    assert [(r.severity, r.code) for r in found.remarks] == [("error", "KS310")]
    assert "'l0'" in found.remarks[0].remedy


def test_what_a_xacro_file_expands_to(tmp_path):
    """Refused without leave; with it, faults say the line of the expansion, which is none of the file."""
    text = arm({(1, "axis"): '<axis xyz="0 0 0"/>'}).replace(
        "<robot ", '<robot xmlns:xacro="http://www.ros.org/wiki/xacro" '
    )
    path = written(tmp_path, "arm.xacro", text)
    refused = inspect_robot(path)
    assert (refused.opened, [r.code for r in refused.remarks]) == (False, ["KS113"])
    found = inspect_robot(path, allow_xacro=True)
    assert [(r.code, r.place.line) for r in found.remarks] == [("KS142", 0)]
    assert "of what it expands to" in found.remarks[0].message


def test_a_large_file_with_many_faults_is_not_read_for_ever(tmp_path):
    """A fault at each of 3000 joints: some are said, in a time that does not grow with their number."""
    pieces = [f'<link name="l{k}"/>' for k in range(3001)]
    pieces += [
        f'<joint name="j{k}" type="fixed"><parent link="l0"/><child link="l{k + 1}"/><origin xyz="0"/></joint>'
        for k in range(3000)
    ]
    found = inspect_robot(written(tmp_path, "big.urdf", f'<robot name="r">{"".join(pieces)}</robot>'))
    assert 2 <= found.count("error") <= 30
    assert not found.complete


def test_a_path_of_another_kind():
    with pytest.raises(ks.ConfigurationError, match=r"(?s)KS429.*arm\.urdf"):
        inspect_robot(7)


# ---- the command ---------------------------------------------------------------------------------------------------------


def test_exit_codes(check, tmp_path):
    """0 clean, 1 errors, 1 warnings with --strict, 2 what cannot be opened; the worst of several files counts."""
    clean, faulty = written(tmp_path, "a.urdf", TEXTS["ok.urdf"]), written(tmp_path, "b.urdf", TEXTS["zero_axis.urdf"])
    doubtful = written(tmp_path, "c.urdf", TEXTS["nonunit_axis.urdf"])
    assert [check(path)[0] for path in (clean, faulty, doubtful, tmp_path / "missing.urdf", tmp_path)] == [0, 1, 0, 2, 2]
    assert check(doubtful, "--strict")[0] == 1
    assert check(clean, doubtful)[0] == 0
    assert check(clean, faulty, tmp_path / "missing.urdf")[0] == 2


def test_a_remark_is_one_line_with_its_place(check, tmp_path):
    """file:line:column: severity code: message, then the remedy, then what it comes to."""
    path = written(tmp_path, "arm.urdf", arm({(2, "axis"): '<axis xyz="0,0,1"/>'}))
    column = path.read_text(encoding="utf-8").splitlines()[7].index("<axis") + 1
    lines = check(path)[1].splitlines()
    assert lines[0] == f"{path}:8:{column}: error KS145: joint 'j2': axis: '0,0,1' is not a number"
    assert lines[1] == "  hint: separate with spaces, not commas"
    assert lines[2] == f"{path}: 1 error (six: 7 links, 6 joints)"


def test_several_files_end_in_a_line_of_all(check, tmp_path):
    paths = [written(tmp_path, name, TEXTS[name]) for name in ("ok.urdf", "zero_axis.urdf", "nonunit_axis.urdf")]
    assert check(*paths)[1].splitlines()[-1] == "3 files, 2 without errors: 1 error, 1 warning, 0 notes"
    assert len(check(paths[0])[1].splitlines()) == 1


def test_notes_can_be_left_out(check, tmp_path):
    path = written(tmp_path, "x.urdf", TEXTS["no_robot_name.urdf"])
    assert "note KS122" in check(path)[1]
    assert "KS122" not in check(path, "--no-notes")[1]


def test_json_holds_the_same(check, tmp_path):
    """Every remark as data, the totals, and the same exit code."""
    paths = [written(tmp_path, name, TEXTS[name]) for name in ("ok.urdf", "zero_axis.urdf")]
    code, text = check(*paths, "--json")
    data = json.loads(text)
    assert (code, data["errors"], data["warnings"]) == (1, 1, 0)
    assert data["files"] == [inspect_robot(path).to_dict() for path in paths]
    remark = data["files"][1]["remarks"][0]
    assert (remark["severity"], remark["code"], remark["line"]) == ("error", "KS142", 1)


def test_a_file_that_may_not_be_read(check, tmp_path, monkeypatch):
    path = written(tmp_path, "secret.urdf", TEXTS["ok.urdf"])

    def refuse(self):
        raise PermissionError(13, "Permission denied", str(self))

    monkeypatch.setattr(Path, "read_bytes", refuse)
    code, text = check(path)
    assert code == 2
    assert "KS109: cannot be read: Permission denied" in text


def test_names_cannot_forge_a_line(check, tmp_path):
    """Line breaks and control characters of a file's names are shown as escapes, so that each remark stays a line."""
    evil = '<axis xyz="x&#10;ok.urdf: nothing to remark&#27;[32m"/>'
    text = check(written(tmp_path, "a.urdf", arm({(0, "axis"): evil}).replace("j0", "j&#10;b.urdf:1:1: note")))[1]
    assert all(c == "\n" or c.isprintable() for c in text)
    assert not [line for line in text.splitlines() if line.startswith(("ok.urdf", "b.urdf"))]


@pytest.mark.parametrize("columns", [60, 80])
def test_lines_fit_a_terminal(check, tmp_path, monkeypatch, columns):
    """On a terminal long messages are wrapped beneath their place; words, so names and paths, are never broken."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("NO_COLOR", "1")
    written(tmp_path, "a.urdf", arm({(0, "axis"): '<axis xyz="0 0 0"/>', (1, "limit"): ""}))
    monkeypatch.setattr("kinestatics.cli.check.line_width", lambda: columns)
    text = check("a.urdf")[1]
    assert max(map(len, text.splitlines())) <= columns
    assert len(text.splitlines()) > len(inspect_robot("a.urdf").remarks) + 2


def test_remarks_stand_in_order(tmp_path):
    """Errors before warnings before notes, each in the order of the file."""
    parts = {(0, "extra"): "<orgin/>", (3, "axis"): '<axis xyz="0 0 0"/>', (1, "mass"): "<mass/>", (5, "extra"): "<orgin/>"}
    found = inspect_robot(written(tmp_path, "a.urdf", arm(parts))).remarks
    order = [(("error", "warning", "note").index(r.severity), r.place.line) for r in found]
    assert len(order) == 4
    assert all(before <= after for before, after in pairwise(order))
