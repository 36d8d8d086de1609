"""Displays in notebooks: the numbers and words that are printed, small, escaped, without script, the same every time."""

import re
import sys
import time
import warnings
from html.parser import HTMLParser

import html5lib
import numpy as np
import pytest

import kinestatics as ks
from hostile_names import NAMES, robot_called
from kinestatics.errors import ArrayTypeError, ConfigurationError, MissingExtraError
from kinestatics.notebook import html
from kinestatics.quantities import format_number
from kinestatics.report.blocks import visible, with_minus
from kinestatics.scene.arm_scene import View

PUMA, PANDA, PLANAR, SCARA = (ks.load(name) for name in ("puma_560", "panda", "planar_2r", "scara"))
SINGULAR = [0.0, 0.3, -1.5, 0.0, 0.0, 0.0]  # of PUMA: the wrist is straight
RESULTS = {
    "robot": lambda: PANDA,
    "planar robot": lambda: PLANAR,
    "sliding robot": lambda: SCARA,
    "jacobian": lambda: ks.jacobian(PANDA, PANDA.home),
    "body jacobian": lambda: ks.jacobian(PUMA, PUMA.home, frame=ks.Frame.body()),
    "jacobian of symbols": lambda: ks.jacobian(ks.exact(PLANAR), ks.joint_symbols(PLANAR)),
    "pose": lambda: ks.pose(PUMA, PUMA.home),
    "twist": lambda: ks.jacobian(PUMA, PUMA.home) @ np.arange(6.0),
    "wrench": lambda: ks.Wrench.on_robot(force=(0, 0, -50)),
    "analysis": lambda: ks.analyze(PANDA, PANDA.home),
    "analysis with a load": lambda: ks.analyze(PUMA, PUMA.home, ks.Wrench.on_robot(force=(0, 0, -50))),
    "singular analysis": lambda: ks.analyze(PUMA, SINGULAR, singularities=True),
    "sliding analysis": lambda: ks.analyze(SCARA, SCARA.home),
    "brief analysis": lambda: ks.analyze(PLANAR, [0.3, 0.5], brief=True),
    "singular set": lambda: ks.singularities(PUMA),
    "closed form": lambda: ks.closed_form("jacobian", PLANAR, lengths="symbols"),
    "determinant": lambda: ks.closed_form("determinant", PUMA, lengths="symbols"),
}


@pytest.fixture(scope="module")
def shown():
    """Every result with its display."""
    made = {name: make() for name, make in RESULTS.items()}
    return {name: (result, result._repr_html_()) for name, result in made.items()}


class Text(HTMLParser):
    """The words of a page, and what its elements and attributes are."""

    def __init__(self, page):
        super().__init__()
        self.words, self.tags, self.attributes, self._inside = [], set(), [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        self.attributes += attrs

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self):
        return "".join(self.words)


def split(page):
    """The printed text of a display, and the display."""
    found = re.fullmatch(
        r'<div class="kinestatics-output"><style>.*?</style><pre class="kinestatics-text">(.*?)</pre>(.*)</div>', page, re.S
    )
    assert found, page[:300]
    return Text(found[1]).text, found[2]


@pytest.mark.parametrize("name", RESULTS)
def test_printed_text_is_beside_the_display(shown, name):
    """Where style is stripped, what is seen is what `print` shows, to the letter; else a display, small, without script."""
    result, page = shown[name]
    text, display = split(page)
    assert text == str(result)
    assert re.match(r'<div class="kinestatics [^"]*" style="display:none">', display)
    assert len(page.encode()) <= 60_000
    parsed = Text(page)
    assert not parsed.tags & {"script", "iframe", "object", "embed", "link", "form", "base", "meta", "img"}
    names = {key for key, _ in parsed.attributes}
    assert not any(key.startswith("on") for key in names)
    assert "id" not in names  # a notebook shows many displays in one page
    assert not re.search(r"url\(|@import|https?://", page)


@pytest.mark.parametrize("name", RESULTS)
def test_displays_are_valid_html(shown, name):
    parser = html5lib.HTMLParser()
    parser.parseFragment(shown[name][1])
    assert not parser.errors


@pytest.mark.parametrize("name", RESULTS)
def test_same_input_same_bytes(shown, name):
    assert RESULTS[name]()._repr_html_() == shown[name][1]


@pytest.mark.parametrize("name", ["jacobian", "body jacobian", "pose", "twist", "analysis", "sliding analysis"])
def test_numbers_are_the_results(shown, name):
    """Every entry is found in the display, rounded as it is printed, in its row and column."""
    result, page = shown[name]
    J = getattr(result, "jacobian", result)
    array = np.atleast_2d(np.asarray(J.array, dtype=float))[: 3 if name == "pose" else 6]
    table = re.search(r'<table class="matrix.*?</table>', page, re.S)[0]
    rows = re.findall(r"<tr>(.*?)</tr>", table, re.S)[1:]
    for numbers, row in zip(array, rows, strict=True):
        cells = [Text(cell).text for cell in re.findall(r"<td[^>]*>(.*?)</td>", row, re.S)]
        assert [cell.split("\u00a0")[0] for cell in cells] == [
            with_minus(format_number(x, np.abs(array).max())) for x in numbers
        ]


def test_frames_units_and_sides_are_said(shown):
    """No bare number: axes, point, units, and of a wrench on whom it acts."""
    for name in ("jacobian", "body jacobian", "twist", "wrench"):
        result, page = shown[name]
        assert str(result.frame) in Text(page.partition("</pre>")[2]).text
    words = {name: Text(shown[name][1].partition("</pre>")[2]).text for name in RESULTS}
    assert "linear rows [m/s], angular rows [rad/s], per unit joint rate" in words["jacobian"]
    assert "acts on the robot" in words["wrench"]
    assert "−50\u00a0N" in words["wrench"]
    assert "seen from base" in words["pose"]
    assert "origin [m]" in words["pose"]
    assert "87\u00a0N m" in words["robot"]
    assert "2.175\u00a0rad/s" in words["robot"]


def test_robot_names_every_joint_and_limit(shown):
    words = Text(shown["robot"][1].partition("</pre>")[2]).text
    for k, name in enumerate(PANDA.joint_names):
        assert name in words
        assert with_minus(f"{PANDA.lower[k]:.4f}".rstrip("0").rstrip(".")) in words


def test_singular_analysis_says_so_first(shown):
    """The verdict and the problem come before any matrix; the picture is that of what is lost."""
    words = Text(shown["singular analysis"][1].partition("</pre>")[2]).text
    assert words.index("rank 5 of 6") < words.index("Singular (wrist)") < words.index("Jacobian")
    assert "Lost motions and free wrenches" in words
    assert "Velocity ellipsoid" in Text(shown["analysis"][1]).text


def test_singular_set_names_conditions_and_postures(shown):
    """det J as mathematics, a row and a picture for each component; the pictured postures are singular."""
    found, page = shown["singular set"]
    words = Text(page.partition("</pre>")[2]).text
    for component in found.components:
        assert component.name in words
        assert f"{component.name}: a posture on it" in words
    assert "<mi>det</mi>" in page or "<mo>det</mo>" in page
    assert page.count("<svg") == 3
    assert "24 of 24 points lose rank" in words


def test_pictured_postures_are_singular():
    """By the singular values of the Jacobian, which `singularities` is not asked about."""
    from kinestatics.notebook.singular import _posture_on

    for component in ks.singularities(PUMA).components:
        J = np.asarray(ks.jacobian(PUMA, _posture_on(component, PUMA.home)))
        sigma = np.linalg.svd(J, compute_uv=False)
        assert sigma[-1] < 1e-9 * sigma[0]


def test_mathematics_is_marked_up(shown):
    """Closed forms and Jacobians of symbols are MathML."""
    for name in ("closed form", "determinant", "jacobian of symbols"):
        assert "<math" in shown[name][1], name


def test_what_is_too_long_is_printed():
    """Batches, long closed forms and arms of many joints are shown as they print: never an error, never a megabyte."""
    batch = ks.jacobian(PUMA, np.zeros((3, 6)))
    assert batch._repr_html_() == f'<div class="kinestatics-output"><pre>{visible(str(batch))}</pre></div>'
    long = ks.closed_form("gravity_torques", PUMA, lengths="symbols") if PUMA.has_masses else None
    for result in (ks.pose(PUMA, np.zeros((3, 6))), ks.Twist.of(linear=np.zeros((2, 3))), long):
        if result is not None:
            assert len(result._repr_html_()) < 60_000


def chain(count):
    """An arm of many joints."""
    joints = "".join(
        f'<link name="l{k}"/><joint name="joint_with_a_long_name_{k}" type="revolute"><parent link="l{k - 1}"/>'
        f'<child link="l{k}"/><origin xyz="0 0 0.1"/><axis xyz="{k % 2} {1 - k % 2} 0"/>'
        '<limit lower="-1" upper="1" velocity="2" effort="3"/></joint>'
        for k in range(1, count + 1)
    )
    return f'<robot name="chain"><link name="l0"/>{joints}</robot>'


@pytest.mark.parametrize("count", [18, 60, 200])
def test_large_robots_stay_small(tmp_path, count):
    """No notebook grows by a robot of many joints, nor stands still."""
    file = tmp_path / "chain.urdf"
    file.write_text(chain(count), encoding="utf-8")
    arm = ks.load(file)
    for result in (arm, ks.jacobian(arm, arm.home), ks.analyze(arm, arm.home, brief=True)):
        assert len(result._repr_html_()) <= 60_000 + 3 * len(str(result))


@pytest.mark.parametrize("name", NAMES)
def test_hostile_names_are_text(tmp_path, name):
    """Names from files make no element and no attribute, in any display and in `show`."""
    arm = ks.load(robot_called(NAMES[name], tmp_path))
    results = [arm, ks.jacobian(arm, arm.home), ks.pose(arm, arm.home), ks.analyze(arm, arm.home)]
    results.append(ks.jacobian(arm, arm.home) @ [1.0, 2.0])
    for result in results:
        parsed = Text(result._repr_html_())
        assert not parsed.tags & {"script", "iframe", "img", "b"}
        assert not any(key.startswith("on") for key, _ in parsed.attributes)
        assert "\u202e" not in parsed.text
    framed = Text(ks.show(arm)._repr_html_())
    assert framed.tags == {"div", "style", "pre", "iframe"}
    assert dict(framed.attributes)["sandbox"] == "allow-scripts"
    assert [key for key, _ in framed.attributes].count("srcdoc") == 1


def test_without_the_extras(monkeypatch):
    """Without latex2mathml the printed formula stands where mathematics would; matplotlib is never asked for."""
    found = ks.singularities(PUMA)
    monkeypatch.setattr("kinestatics.notebook.frame.find_spec", lambda _: None)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    page = found._repr_html_()
    assert "<math" not in page
    assert "<code>sin(q5) = 0</code>" in page
    closed = ks.closed_form("jacobian", PLANAR, lengths="symbols")._repr_html_()
    assert "<code>a1</code>" in closed
    assert "<svg" in ks.analyze(PUMA)._repr_html_()


def test_a_broken_display_shows_what_is_printed(monkeypatch):
    """Whatever fails inside, the cell shows the numbers."""
    monkeypatch.setattr("kinestatics.notebook.robot.robot_body", lambda _: 1 / 0)
    assert html(PLANAR) == f'<div class="kinestatics-output"><pre>{PLANAR}</pre></div>'


def test_displays_are_quick(shown):
    """Once it was shown, a display takes at most 0.3 s."""
    for name, (result, _) in shown.items():
        best = min(_seconds(result) for _ in range(3))
        assert best <= 0.3, name


def _seconds(result):
    began = time.process_time()
    result._repr_html_()
    return time.process_time() - began


def test_displays_warn_of_nothing(shown):
    """Not even at a singular posture, whose ellipsoids have no end."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        for result, _ in shown.values():
            result._repr_html_()
    assert not told


@pytest.fixture(scope="module")
def scene():
    """A scene with everything in it."""
    return ks.show(PUMA, SINGULAR, wrench=ks.Wrench.on_robot(force=(0, 0, -50)))


def test_is_one_page_of_moderate_size(scene):
    assert scene.html.startswith("<!doctype html>")
    assert len(scene.html) <= 3_000_000
    assert len(scene._repr_html_()) <= 3_000_000


def test_same_scene_same_bytes(scene):
    again = ks.show(PUMA, SINGULAR, wrench=ks.Wrench.on_robot(force=(0, 0, -50)))
    assert again == scene
    assert again._repr_html_() == scene._repr_html_()


def test_shows_what_was_asked(scene):
    """Another posture, load or view is another scene."""
    others = [
        ks.show(PUMA),
        ks.show(PUMA, SINGULAR),
        ks.show(PUMA, SINGULAR, view=View(velocity="none")),
        ks.show(PANDA),
        ks.show(PANDA, view=View(velocity="polytope")),
    ]
    assert len({scene.html, *(other.html for other in others)}) == 6


def test_is_saved_as_it_is(scene, tmp_path):
    file = scene.save(tmp_path / "arm.html")
    assert file.read_bytes() == scene.html.encode()


def test_says_how_to_be_seen(scene):
    assert repr(scene) == (
        '<puma_560 in three dimensions: a notebook displays it; else .save("arm.html"), and open that file in a browser>'
    )
    assert "in the file that .save(path) writes" in scene._repr_html_()  # where frames are stripped


def test_frame_holds_the_page(scene):
    """What the frame is given is the page, whole; it may run script and nothing else."""
    (tag,) = [dict(attrs) for attrs in [Text(scene._repr_html_()).attributes]]
    assert tag["srcdoc"] == scene.html
    assert tag["sandbox"] == "allow-scripts"
    assert "height:480px" in tag["style"]


@pytest.mark.parametrize("height", [0, -1, 10**6, 480.0, "480", True, None])
def test_refuses_a_height_that_is_none(height):
    with pytest.raises(ConfigurationError, match=r"KS450.*height is"):
        ks.show(PLANAR, height=height)


@pytest.mark.parametrize("view", ["polytope", (30, 40), {"velocity": "none"}])
def test_refuses_a_view_that_is_none(view):
    with pytest.raises(ArrayTypeError, match=r"KS451.*expected a View"):
        ks.show(PLANAR, view=view)


def test_refuses_what_is_no_robot_or_posture():
    with pytest.raises(ArrayTypeError, match="KS302"):
        ks.show("planar_2r")
    with pytest.raises(ConfigurationError, match="KS303"):
        ks.show(PLANAR, [0.1])


@pytest.mark.parametrize("path", ["no/such/folder/arm.html", ".", "a\0b", 3.5])
def test_says_why_a_file_cannot_be_written(scene, tmp_path, monkeypatch, path):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ConfigurationError, match=r"KS452.*cannot be written"):
        scene.save(path)


def test_needs_viser(monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingExtraError, match="KS400"):
        ks.show(PLANAR)
