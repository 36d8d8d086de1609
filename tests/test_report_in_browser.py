"""Reports in a browser, opened from disk: nothing runs, nothing leaves, everyone can read them."""

import pytest

import kinestatics as ks
from browser import browser_fixture, page_of_fixture  # noqa: F401 - fixtures
from hostile_names import NAMES, robot_called

axe_module = pytest.importorskip("axe_playwright_python.sync_playwright")
UR5E = [0.3, -1.1, 1.4, -0.6, 1.2, 0.2]


@pytest.fixture(scope="module")
def reports(tmp_path_factory):
    """Three pages on disk: an arm with a load over its limits, a singular one, and one to be turned."""
    folder = tmp_path_factory.mktemp("reports")
    heavy = ks.analyze(ks.load("ur5e"), UR5E, ks.Wrench.on_robot(force=(0, 0, -300)), singularities=True)
    straight = ks.analyze(ks.load("planar_2r"), [0.4, 0.0], ks.Wrench.on_robot(force=(-20, -10, 0)), singularities=True)
    pages = {"heavy": heavy.to_html(), "straight": straight.to_html(), "turning": heavy.to_html(interactive=True)}
    for name, text in pages.items():
        (folder / f"{name}.html").write_text(text, encoding="utf-8")
    return folder


def opened(page_of, file, **options):
    """A tab, and all that it asked for."""
    tab = page_of(None, **options)
    asked = []
    tab.page.on("request", lambda request: asked.append(request.url))
    tab.page.goto(file.as_uri())
    return tab, asked


def assert_alone(tab, asked, file):
    """The page and what it carries itself are all that was asked for."""
    tab.assert_quiet()
    assert [url for url in asked if not url.startswith(("data:", "blob:"))] == [file.as_uri()]


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("name", ["heavy", "straight"])
def test_axe_finds_nothing_serious(page_of, reports, name, scheme):
    """Contrast in light and dark, names, heads of tables, landmarks, order of headings: axe-core has nothing to say."""
    tab, asked = opened(page_of, reports / f"{name}.html", color_scheme=scheme)
    found = axe_module.Axe().run(tab.page).response["violations"]
    assert [(v["id"], v["impact"], [node["html"][:120] for node in v["nodes"][:3]]) for v in found] == []
    assert_alone(tab, asked, reports / f"{name}.html")


@pytest.mark.parametrize("name", ["heavy", "straight"])
def test_narrow_window_scrolls_only_down(page_of, reports, name):
    """At 360 pixels the page is as wide as the window; what is wider scrolls in a box that the keyboard reaches."""
    tab, _ = opened(page_of, reports / f"{name}.html", width=360)
    assert tab.page.evaluate("document.documentElement.scrollWidth") == 360
    inside = "e.getBoundingClientRect().right <= 361 || e.closest('.scroll')"
    out = f"[...document.querySelectorAll('main *')].filter(e => !({inside}))"
    assert tab.page.evaluate(f"{out}.map(e => e.outerHTML.slice(0, 80))") == []
    wide = "[...document.querySelectorAll('.scroll')].filter(e => e.scrollWidth > e.clientWidth)"
    assert tab.page.evaluate(f"{wide}.every(e => e.tabIndex === 0)")


def test_brackets_grow_with_their_matrix(page_of, reports):
    """The font of the page is in use: without its table of mathematics, brackets stay as small as letters."""
    tab, _ = opened(page_of, reports / "heavy.html")
    heights = tab.page.evaluate(
        "[...document.querySelectorAll('math')].filter(m => m.querySelector('mtable') && m.textContent.includes('['))"
        ".map(m => [m.querySelector('mtable').getBoundingClientRect().height,"
        " [...m.querySelectorAll('mo')].find(o => o.textContent === '[').getBoundingClientRect().height])"
    )
    assert len(heights) >= 2
    assert all(bracket > 0.9 * matrix for matrix, bracket in heights)
    assert tab.page.evaluate("document.fonts.check('16px \"Kinestatics Mathematics\"')")


def test_prints_on_a_few_pages(page_of, reports):
    """The browser's own PDF: no more than a report of eight pages."""
    tab, _ = opened(page_of, reports / "heavy.html")
    made = tab.page.pdf(format="A4")
    assert made.startswith(b"%PDF-")
    assert 3 <= made.count(b"/Type /Page\n") <= 9


def test_works_without_script(page_of, reports):
    """The static page loses nothing where script is off."""
    text = "document.body.innerText"
    with_script, _ = opened(page_of, reports / "straight.html")
    shown = with_script.page.evaluate(text)
    without, _ = opened(page_of, reports / "straight.html", java_script_enabled=False)
    assert without.page.inner_text("body") == shown
    assert "Singular (elbow)" in shown


@pytest.mark.parametrize("kind", NAMES)
def test_no_script_of_a_hostile_name_runs(page_of, kind, tmp_path):
    """Static, and for some to be turned: nothing runs, nothing is asked for, and the name is there to be read."""
    arm = ks.load(robot_called(NAMES[kind], tmp_path))
    a = ks.analyze(arm, [0.2, 0.5], ks.Wrench.on_robot(force=(0, 0, -5)))
    for interactive in (False, True) if kind in ("script", "style") else (False,):
        file = tmp_path / f"report{interactive}.html"
        file.write_text(a.to_html(interactive=interactive, command=NAMES[kind]), encoding="utf-8")
        tab, asked = opened(page_of, file)
        tab.page.hover("h1")
        assert tab.page.evaluate("window.RAN") is None
        assert not tab.page.query_selector_all("iframe, img:not([src^='data:']), body link, a[href^='javascript']")
        head = tab.page.inner_text("h1")
        assert head[:3].strip() == NAMES[kind].replace("\u202e", "\\u2")[:3].replace("\n", " ")
        assert_alone(tab, asked, file)


def test_figures_can_be_turned(page_of, reports):
    """plotly draws both figures within a policy that lets it fetch nothing; the values are the analysis's."""
    tab, asked = opened(page_of, reports / "turning.html")
    tab.wait_until(lambda: tab.page.evaluate("document.querySelectorAll('.js-plotly-plot .main-svg').length") >= 3)
    tab.wait_until(lambda: tab.page.query_selector("#figure-arm canvas"))
    traces = tab.page.evaluate("document.getElementById('figure-measure').data.map(t => [t.name, t.x.length, t.y[60]])")
    arm = ks.load("ur5e")
    assert [name for name, *_ in traces] == [f"{joint} [°]" for joint in arm.joint_names]
    middle = [[*UR5E[:k], (arm.lower[k] + arm.upper[k]) / 2, *UR5E[k + 1 :]] for k in range(6)]
    expected = ks.manipulability(ks.jacobian(arm, middle))
    assert [y for *_, y in traces] == pytest.approx(list(expected))
    assert_alone(tab, asked, reports / "turning.html")


def test_scene_is_drawn_in_a_frame_of_its_own(page_of, tmp_path):
    """The arm in three dimensions, drawn from what the page carries: nothing is asked for, and the frame is shut in."""
    pytest.importorskip("viser")
    file = tmp_path / "scene.html"
    a = ks.analyze(ks.load("planar_2r"), [0.4, 0.6])
    file.write_text(a.to_html(scene=True), encoding="utf-8")
    assert file.stat().st_size < 9_000_000
    tab, asked = opened(page_of, file)
    tab.page.query_selector("iframe").scroll_into_view_if_needed()
    frame = tab.page.query_selector("iframe").content_frame()
    tab.wait_until(lambda: frame.query_selector("canvas"), 60)
    assert tab.page.query_selector("iframe").get_attribute("sandbox") == "allow-scripts"
    assert frame.evaluate("window.origin") == "null"
    assert_alone(tab, asked, file)
