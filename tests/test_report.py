"""Reports: valid, safe, small, the same on every run, and true to the analysis in every number."""

import dataclasses
import hashlib
import html
import itertools
import json
import os
import re
import subprocess
import sys
import zlib

import html5lib
import numpy as np
import pytest
from typer.testing import CliRunner

import kinestatics as ks
from hostile_names import NAMES, robot_called
from kinestatics import report
from kinestatics.cli.app import app
from kinestatics.report import blocks, mathematics
from kinestatics.report.findings import SEVERITIES, remarks_of
from kinestatics.robots.catalogue import catalogue_names

X = "{http://www.w3.org/1999/xhtml}"
M = "{http://www.w3.org/1998/Math/MathML}"
UR5E = [0.3, -1.1, 1.4, -0.6, 1.2, 0.2]


def parsed(page):
    """The tree of a page, which must be valid HTML."""
    return html5lib.HTMLParser(strict=True).parse(page)


def words(element):
    return re.sub(r"\s+", " ", "".join(element.itertext())).strip()


def number_of(text):
    """The first number in a text, with a true minus."""
    return float(re.search(r"[-\d.e]+", text.replace("\N{MINUS SIGN}", "-"))[0])


def table_of(tree, caption):
    """{name of a row: cells} of the table whose caption begins so."""
    for table in tree.iter(f"{X}table"):
        if words(table.find(f"{X}caption")).startswith(caption):
            rows = table.find(f"{X}tbody").findall(f"{X}tr")
            return {words(row[0]): [words(cell) for cell in row[1:]] for row in rows}
    raise AssertionError(f"no table {caption!r}")


@pytest.fixture(scope="module")
def loaded():
    arm = ks.load("ur5e")
    return ks.analyze(arm, UR5E, ks.Wrench.on_robot(force=(5, 0, -80), torque=(1, 0, 0)), singularities=True)


@pytest.fixture(scope="module")
def page(loaded):
    return loaded.to_html(command="kinestatics analyze ur5e", seed=3)


@pytest.fixture(scope="module")
def tree(page):
    return parsed(page)


@pytest.fixture(scope="module")
def straight():
    """A planar arm, singular, pushing along itself."""
    arm = ks.load("planar_2r")
    return ks.analyze(arm, [0.4, 0.0], ks.Wrench.on_environment(force=(20, 0, 0)), singularities=True)


def test_numbers_are_those_of_the_analysis(loaded, tree):
    """Jacobian, singular values, torques, shares, distances, masses and hash, as printed to four decimals."""
    matrix = next(t for t in tree.iter(f"{M}mtable") if t.get("columnlines"))
    rows = [[words(cell) for cell in row] for row in matrix][1:]
    shown = np.array([[float(x.replace("\N{MINUS SIGN}", "-")) for x in row[1:]] for row in rows])
    np.testing.assert_allclose(shown, loaded.jacobian.array, atol=5e-5)
    assert [row[0] for row in rows] == ["vx", "vy", "vz", "ωx", "ωy", "ωz"]
    values = [number_of(cells[0]) for cells in table_of(tree, "Singular values").values()]
    np.testing.assert_allclose(values, loaded.singular_values, atol=5e-5)
    torques = table_of(tree, "Holding torques")
    assert list(torques) == list(loaded.joints)
    columns = (loaded.gravity_torques, loaded.joint_torques, loaded.holding_torques, loaded.effort_limits)
    for k, expected in enumerate(columns):
        np.testing.assert_allclose([number_of(cells[k]) for cells in torques.values()], expected, atol=5e-5)
    shares = [number_of(cells[4]) for cells in torques.values()]
    np.testing.assert_allclose(shares, 100 * loaded.effort_shares, rtol=5e-3, atol=6e-3)
    distances = table_of(tree, "Singularities")
    assert list(distances) == [found.component.label for found in loaded.near]
    np.testing.assert_allclose([number_of(c[0]) for c in distances.values()], [d.value for d in loaded.near], atol=5e-5)
    np.testing.assert_allclose([number_of(c[1]) for c in distances.values()], [d.at_least for d in loaded.near], atol=5e-5)
    able = table_of(tree, "With the limits")
    np.testing.assert_allclose([number_of(c[0]) for c in able.values()], [x.speed for x in loaded.abilities], atol=5e-5)
    bearings = table_of(tree, "What a bearing carries")
    np.testing.assert_allclose([number_of(c[2]) for c in bearings.values()], loaded.reactions.bending, atol=5e-5)
    text = words(tree)
    model = ks.load("ur5e")
    assert model.digest in text
    assert "kinestatics analyze ur5e" in text


def test_loads_are_divided_as_the_analysis_does(straight):
    """A push along a straight arm: the structure holds it, and the page says who pushes whom, in which axes."""
    rows = table_of(parsed(straight.to_html()), "Push of the robot on its surroundings at tip: axes of base")
    split = straight.loads[0].split
    for name, wrench in zip(rows, (split.load, split.active, split.structure), strict=True):
        np.testing.assert_allclose([number_of(x) for x in rows[name]], wrench.array, atol=5e-5)
    assert list(rows) == ["as given", "made by the motors", "held by the structure"]


def test_the_page_can_neither_run_nor_fetch(page, tree):
    """No script, no address, and a policy that would stop both."""
    assert not list(tree.iter(f"{X}script"))
    assert not re.search(r"https?:", page)
    assert not re.findall(r"url\((?!data:)", page)
    assert not [e for e in tree.iter() for name in e.attrib if str(name).startswith("on")]
    policy = next(e.get("content") for e in tree.iter(f"{X}meta") if e.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none';")
    assert "script" not in policy


def test_structure_can_be_read_aloud(tree):
    """One h1; no level is skipped; ids are single; sections and pictures have names; cells have heads."""
    levels = [int(e.tag[-1]) for e in tree.iter() if re.fullmatch(re.escape(X) + r"h\d", str(e.tag))]
    assert levels.count(1) == 1
    assert all(b - a <= 1 for a, b in itertools.pairwise(levels))
    ids = [e.get("id") for e in tree.iter() if e.get("id")]
    assert len(set(ids)) == len(ids)
    labelled = {e.get("aria-labelledby") for e in tree.iter() if e.get("aria-labelledby")}
    assert labelled <= set(ids)
    pictures = [e for e in tree.iter() if e.get("role") == "img"]
    assert len(pictures) >= 5
    assert all(len(e.get("aria-label")) > 40 for e in pictures)
    assert {e.get("scope") for e in tree.iter(f"{X}th")} == {"row", "col"}
    assert next(tree.iter(f"{X}html")).get("lang") == "en"


def test_conventions_come_before_any_matrix(page):
    for word in ("linear before angular", "minus Jᵀ times a load", "Characteristic length", "origin of tool0"):
        assert page.index(word) < page.index("<math"), word


@pytest.mark.parametrize("name", catalogue_names())
def test_every_arm_of_the_catalogue_has_a_report(name):
    """Valid, and a third of the size that is allowed."""
    made = ks.analyze(ks.load(name)).to_html()
    assert words(next(parsed(made).iter(f"{X}h1"))) == name
    assert len(made.encode()) < 250_000


@pytest.mark.parametrize("name", ["scara", "stanford_arm", "rrp_note_000"])
def test_sliding_joints_have_their_own_units(name):
    made = parsed(ks.analyze(ks.load(name), singularities=True).to_html())
    kinds = dict(zip(ks.load(name).joint_names, ks.load(name).joint_kinds, strict=True))
    for joint, cells in table_of(made, "Joints").items():
        assert ("m" if kinds[joint] == "prismatic" else "rad") in cells[1].split()[1]


def test_closed_forms_are_mathematics(tree):
    """det J in its factors; the Jacobian in axes that make it short; numbers for its lengths."""
    formulas = [words(e) for e in tree.iter(f"{M}math")]
    assert any(text.startswith("detJ=−a2a3") for text in formulas)
    assert "a2=0.425m" in [text.replace(" ", "") for text in formulas]
    assert all(e.tag.startswith(M) for math in tree.iter(f"{M}math") for e in math.iter())


def test_long_formulas_are_left_out_and_the_page_says_so():
    wide = ks.from_dh([(0.2, 0.3, 0.1, 0)] * 8, convention="standard")
    assert "too long to read" in words(parsed(ks.analyze(wide, np.zeros(8)).to_html()))


def test_findings_are_sorted_and_say_what_to_do(straight):
    """The gravest first, each with a remedy; missing data is told."""
    found = remarks_of(straight)
    ranks = [SEVERITIES.index(remark.severity) for remark in found]
    assert ranks == sorted(ranks)
    assert found[0].title.startswith("Singular (elbow): rank 1 of 2")
    assert all(remark.remedy for remark in found)
    assert any("limits are unknown" in remark.title for remark in found)


def test_findings_near_and_beyond():
    """Near a limit, outside one, near a singularity, over the limit of a motor: each is named with its amount."""
    arm = ks.load("puma_560")
    q = np.array([arm.upper[0] - 0.01, arm.lower[1] - 0.2, 0.9, 0.3, 0.05, 0.2])
    found = {remark.title: remark.severity for remark in remarks_of(ks.analyze(arm, q, singularities=True))}
    assert found["joint1 is 0.01\u00a0rad (0.57°) from its upper limit."] == "warning"
    assert found["joint2 is outside its lower limit by 0.2\u00a0rad (11.46°)."] == "problem"
    assert found["Near a singularity (wrist): 0.05 rad away in joint space."] == "warning"
    heavy = ks.analyze(ks.load("ur5e"), UR5E, ks.Wrench.on_robot(force=(0, 0, -400)))
    over = [remark for remark in remarks_of(heavy) if "of its limit of 150 N m" in remark.title]
    assert over[0].severity == "problem"
    assert heavy.effort_shares.max() > 1
    assert remarks_of(ks.analyze(ks.load("ur5e"), UR5E, singularities=True)) == []


def test_effort_shares():
    """|torque| / limit; unknown limits are NaN, a motor without effort that must hold is beyond any."""
    a = ks.analyze(ks.load("ur5e"), UR5E)
    np.testing.assert_allclose(a.effort_shares, np.abs(a.gravity_torques) / a.effort_limits)
    limits = np.array([150, 0, np.inf, 28, 28, 28.0])
    changed = dataclasses.replace(a, effort_limits=limits)
    assert np.isinf(changed.effort_shares[1])
    assert np.isnan(changed.effort_shares[2])
    assert ks.analyze(ks.load("panda")).effort_shares is None


def test_card_and_set_are_in_the_analysis(loaded):
    """The distances are the card's, and no set is looked for where none is asked for."""
    assert loaded.near is loaded.card.near
    assert loaded.singular_set.task.rank == 6
    plain = ks.analyze(ks.load("ur5e"), UR5E)
    assert plain.near is plain.card is plain.singular_set is None
    assert "Not looked for" in words(parsed(plain.to_html()))


@pytest.mark.parametrize("kind", NAMES)
def test_hostile_names_are_text(kind, tmp_path):
    """Whatever a file calls its robot, links and joints: it is shown, and it is text."""
    arm = ks.load(robot_called(NAMES[kind], tmp_path))
    a = ks.analyze(arm, [0.2, 0.5], ks.Wrench.on_robot(force=(0, 0, -5)), singularities=True)
    made = a.to_html(command=f"kinestatics analyze {NAMES[kind]!r}")
    tree = parsed(made)
    allowed = {"html", "head", "body", "meta", "title", "style", "svg", "path", "circle", "text", "math"}
    unknown = {str(e.tag).rpartition("}")[2] for e in tree.iter()} & {
        "script",
        "iframe",
        "img",
        "object",
        "embed",
        "link",
        "b",
    }
    assert not unknown - allowed
    assert not [name for e in tree.iter() for name in e.attrib if str(name).startswith("on")]
    assert words(next(tree.iter(f"{X}h1"))) == re.sub(r"\s+", " ", blocks.visible(NAMES[kind])).strip()
    assert not re.search("[\u202a-\u202e\u2066-\u2069\x00-\x08]", made)
    assert len(made.encode()) < 500_000


def test_names_of_any_length_are_shown():
    """Also of a robot that was made in Python."""
    arm = ks.load("planar_2r")
    long = dataclasses.replace(arm, name="n" * 10_000, joint_names=("j" * 10_000, "\ud800lone"))
    made = ks.analyze(long, [0.1, 0.2]).to_html()
    assert len(made.encode()) < 200_000
    assert "\\ud800lone" in made


CODE = """
import sys, kinestatics as ks
a = ks.analyze(ks.load("scara"), wrench=ks.Wrench.on_robot(force=(0, 0, -80)), singularities=True)
b = ks.analyze(ks.load("planar_2r"), [0.4, 0.0], singularities=True)
sys.stdout.buffer.write(a.to_html().encode() + b.to_html(interactive=True).encode())
"""


def test_same_input_same_bytes():
    """Two processes whose sets and dictionaries are ordered by different hashes."""
    digests = set()
    for seed in ("1", "2"):
        run = subprocess.run(
            [sys.executable, "-c", CODE], capture_output=True, check=True, env={**os.environ, "PYTHONHASHSEED": seed}
        )
        digests.add(hashlib.sha256(run.stdout).hexdigest())
    assert len(digests) == 1


def test_pdf_has_pages_with_text(straight):
    """It begins as one, is the same twice, and holds letters, not a picture of them."""
    made = report.pdf(straight)
    assert made.startswith(b"%PDF-")
    assert made == report.pdf(straight)
    streams = re.findall(rb"stream\r?\n(.*?)endstream", made, re.DOTALL)
    texts = [zlib.decompressobj().decompress(s) for s in streams if s[:1] == b"x"]
    assert sum(text.count(b"TJ") + text.count(b"Tj") for text in texts) > 200
    assert len(re.findall(rb"/Type ?/Page\b", b" ".join([made, *texts]))) >= 2


def test_interactive_page_brings_its_script_along(straight):
    made = straight.to_html(interactive=True)
    assert 1_000_000 < len(made.encode()) < 5_500_000
    assert "script-src 'unsafe-inline'" in html.unescape(made[:1000])
    assert made.count('class="plotly-graph-div"') == 2


@pytest.mark.parametrize(
    ("module", "package", "make"),
    [
        (mathematics, "latex2mathml", report.html),
        (mathematics, "ziamath", report.pdf),
        (report, "weasyprint", report.pdf),
        ("interactive", "plotly", lambda a: report.html(a, interactive=True)),
    ],
    ids=["latex2mathml", "ziamath", "weasyprint", "plotly"],
)
def test_missing_extra(monkeypatch, straight, module, package, make):
    from kinestatics.report import interactive

    def find(name):
        return None if name == package else True

    monkeypatch.setattr(interactive if module == "interactive" else module, "find_spec", find)
    with pytest.raises(ks.MissingExtraError, match=r"kinestatics\[report\]") as error:
        make(straight)
    assert error.value.code == "KS400"
    assert package in error.value.message


def test_only_analyses_have_reports():
    with pytest.raises(ks.ArrayTypeError, match="expected an Analysis, not a RobotModel"):
        report.html(ks.load("planar_2r"))


# mathematics and blocks


def test_mathematics_is_repaired():
    """T without serifs, names as one word, marks of LaTeX in names as they are."""
    assert "𝖳" in mathematics.mathml(r"J^{\mathsf T}")
    assert "<mi>Ad</mi>" in mathematics.mathml(r"\mathrm{Ad}_g")
    assert "<mtext>a_b{c} &amp; 50%</mtext>" in mathematics.mathml(r"\text{a\_b\{c\} \& 50\%}")
    assert mathematics.mathml(r"\frac{1}{") == r"<code>\frac{1}{</code>"


def test_font_is_small_and_comes_with_its_licence():
    from importlib import resources

    folder = resources.files("kinestatics.report").joinpath("fonts")
    assert len(folder.joinpath(mathematics.FONT).read_bytes()) < 70_000
    assert "SIL OPEN FONT LICENSE" in folder.joinpath("OFL.txt").read_text(encoding="utf-8")


def test_blocks_escape_all_they_are_given():
    evil = "\"><script>'&\u202e"
    table = blocks.table(evil, [evil, blocks.Column(evil, evil)], [[evil, evil]])
    made = [table, blocks.section(evil, evil, id="a"), blocks.badge(evil), blocks.definitions([(evil, evil)])]
    assert "<script" not in "".join(made)
    assert "\u202e" not in "".join(made)
    assert blocks.tag("p", title=evil) == '<p title="&quot;&gt;&lt;script&gt;&#x27;&amp;\\u202e"></p>'


# the command


def run(*arguments):
    return CliRunner().invoke(app, ["analyze", *map(str, arguments)])


def test_command_writes_a_report(tmp_path, monkeypatch):
    """The page is whole, nothing is left beside it, and what was asked is in it without where it went."""
    out = tmp_path / "out.html"
    monkeypatch.setattr(sys, "argv", ["kinestatics", "analyze", "planar_2r", "--report", str(out), "--at", "0.4,0"])
    done = run("planar_2r", "--report", out, "--at", "0.4,0")
    assert done.exit_code == 0, done.output
    assert list(tmp_path.iterdir()) == [out]
    assert "problem: Singular (elbow)" in done.output
    text = words(parsed(out.read_text(encoding="utf-8")))
    assert "kinestatics analyze planar_2r --at 0.4,0" in text
    assert str(tmp_path) not in text
    as_json = run("planar_2r", "--report", out, "--json")
    assert json.loads(as_json.output)["robot"] == "planar_2r"


def test_command_writes_pdf(tmp_path):
    out = tmp_path / "out.PDF"
    assert run("planar_2r", "--report", out, "--no-singularities").exit_code == 0
    assert out.read_bytes().startswith(b"%PDF-")


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("--report", "out.txt"), "KS410"),
        (("--report", "no/such/folder/out.html"), "KS411"),
        (("--report", "out.pdf", "--interactive"), "KS413"),
        (("--scene",), "KS414"),
        (("--interactive",), "KS414"),
    ],
)
def test_command_refuses_before_it_computes(arguments, code):
    """The robot is not even looked for."""
    with pytest.raises(ks.KinestaticsError) as error:
        CliRunner().invoke(app, ["analyze", "no_such_robot", *arguments], catch_exceptions=False)
    assert error.value.code == code
    assert error.value.hint


def test_a_failed_report_leaves_the_old_one(tmp_path, monkeypatch):
    out = tmp_path / "out.html"
    out.write_text("old")

    def fail(*_):
        raise OSError(28, "No space left on device", "out.html")

    monkeypatch.setattr(os, "replace", fail)
    done = run("planar_2r", "--report", out, "--no-singularities")
    assert isinstance(done.exception, OSError)
    assert list(tmp_path.iterdir()) == [out]
    assert out.read_text() == "old"
