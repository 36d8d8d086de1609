"""A saved notebook in a browser: as hosts of light and dark themes show it, and as those that strip style do."""

import ast
import html

import pytest

import kinestatics as ks
from browser import browser_fixture, page_of_fixture  # noqa: F401 - fixtures
from hostile_names import NAMES, robot_called

CELLS = [
    "import kinestatics as ks\nimport numpy as np\narm = ks.load('puma_560')\narm",
    "q = [0.0, 0.3, -1.5, 0.0, 0.0, 0.0]\nks.jacobian(arm, q)",
    "ks.pose(arm, q)",
    "ks.analyze(arm, q, singularities=True)",
    "ks.singularities(arm)",
    "ks.closed_form('jacobian', ks.load('planar_2r'), lengths='symbols')",
]
LAB = """
  .jp-RenderedHTMLCommon table { table-layout: fixed; margin-left: auto; margin-right: auto; border: none; font-size: 12px; }
  .jp-RenderedHTMLCommon td, .jp-RenderedHTMLCommon th { text-align: right; padding: 0.5em; white-space: normal; }
  .jp-RenderedHTMLCommon tbody tr:nth-child(odd) { background: rgb(200, 200, 200); }
"""
HOSTS = {
    "light": ("#ffffff", "#1a1a1a", 'data-jp-theme-light="true"'),
    "dark": ("#111111", "#e0e0e0", 'data-jp-theme-light="false"'),
    "code": ("#1e1e1e", "#cccccc", 'class="vscode-dark"'),
}
LUMINANCE = """() => {
  const channel = x => (x /= 255) <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
  const numbers = color => {  // what the browser paints
    const pen = Object.assign(document.createElement("canvas"), {width: 1, height: 1}).getContext("2d");
    const back = getComputedStyle(document.body).backgroundColor;
    pen.fillStyle = back; pen.fillRect(0, 0, 1, 1); pen.fillStyle = color; pen.fillRect(0, 0, 1, 1);
    return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3);
  };
  const luminance = color => { const [r, g, b] = numbers(color).map(channel); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  const behind = element => {
    for (; element; element = element.parentElement) {
      const back = getComputedStyle(element).backgroundColor;
      if (back !== "rgba(0, 0, 0, 0)") return back;
    }
  };
  const found = [];
  for (const element of document.querySelectorAll(".kinestatics *")) {
    const own = [...element.childNodes].some(node => node.nodeType === 3 && node.textContent.trim());
    if (!own || !element.getClientRects().length) continue;
    const svg = element.namespaceURI.endsWith("svg");
    const style = getComputedStyle(element);
    const [a, b] = [luminance(svg ? style.fill : style.color), luminance(behind(element))].sort((x, y) => y - x);
    found.push([(a + 0.05) / (b + 0.05), element.textContent.slice(0, 40)]);
  }
  return found.sort((x, y) => x[0] - y[0]).slice(0, 5);
}"""


def outputs(cells):
    """What the cells of a notebook show: each is run, and its last line displayed as Jupyter and marimo do."""
    names, found = {}, []
    for cell in cells:
        tree = ast.parse(cell)
        last = ast.Expression(tree.body.pop().value)
        exec(compile(tree, "<cell>", "exec"), names)
        found.append(eval(compile(last, "<cell>", "eval"), names)._repr_html_())
    return found


def page_with(displays, host="light", styles=LAB):
    """A page of a host with the outputs of cells."""
    back, ink, attributes = HOSTS[host]
    cells = "".join(f'<div class="jp-RenderedHTMLCommon">{display}</div>' for display in displays)
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>notebook</title><style>{styles}</style></head>'
        f'<body {attributes} style="background:{back};color:{ink};font-family:sans-serif">{cells}'
        '<table class="other"><tr><th>of another library</th><td>1</td></tr></table></body></html>'
    )


@pytest.fixture(scope="module")
def displays():
    """The outputs of the notebook."""
    return outputs(CELLS)


@pytest.fixture
def opened(page_of, tmp_path):
    """Opens a page from disk, as a saved notebook is."""

    def open_page(text, **options):
        file = tmp_path / "notebook.html"
        file.write_text(text, encoding="utf-8")
        return page_of(f"file://{file}", **options)

    return open_page


@pytest.mark.parametrize("host", HOSTS)
def test_displays_are_seen_and_read(opened, displays, host):
    """Display instead of text; contrast of every word at least 4.5; nothing is asked for, nothing goes wrong."""
    tab = opened(page_with(displays, host))
    page = tab.page
    assert page.locator(".kinestatics:visible").count() == len(CELLS)
    assert page.locator(".kinestatics-text:visible").count() == 0
    worst = page.evaluate(LUMINANCE)
    assert worst[0][0] >= 4.5, worst
    tab.assert_quiet()


def test_rules_of_the_host_are_kept_off_and_theirs_alone(opened, displays):
    """Tables keep their look among a host's rules; what is not of a display keeps that of the host."""
    tab = opened(page_with(displays, "light"))
    style = "element => { const s = getComputedStyle(element); return [s.textAlign, s.backgroundColor, s.tableLayout]; }"
    with_displays = tab.page.locator(".other th").evaluate(style)
    align, back, _ = tab.page.locator(".kinestatics tbody th").first.evaluate(style)
    assert align == "left"
    assert tab.page.locator(".kinestatics tbody tr").first.evaluate(style)[1] == "rgba(0, 0, 0, 0)" == back
    assert tab.page.locator(".kinestatics table").first.evaluate(style)[2] == "auto"
    without = opened(page_with([], "light"))
    assert without.page.locator(".other th").evaluate(style) == with_displays


def test_printed_text_where_style_is_stripped(opened, displays):
    """GitHub and untrusted notebooks take the style sheet: then the text that is printed is read, and not twice."""
    stripped = [display[: display.index("<style>")] + display[display.index("</style>") + 8 :] for display in displays]
    tab = opened(page_with(stripped, "light"))
    assert tab.page.locator(".kinestatics:visible").count() == 0
    texts = tab.page.locator(".kinestatics-text:visible").all_inner_texts()
    assert texts[0] == str(ks.load("puma_560"))
    assert len(texts) == len(CELLS)


def test_narrow_cells_scroll_inside(opened, displays):
    """In a column of a phone's width the page does not grow sideways."""
    tab = opened(page_with(displays, "light"), width=390)
    assert tab.page.evaluate("document.documentElement.scrollWidth <= innerWidth")


def test_hostile_names_run_nothing(opened, tmp_path):
    """No script runs, in displays or in the frame of a scene, and nothing leaves the machine."""
    arms = [ks.load(robot_called(name, tmp_path)) for name in NAMES.values()]
    results = [
        r for arm in arms for r in (arm, ks.jacobian(arm, arm.home), ks.pose(arm, arm.home), ks.analyze(arm, arm.home))
    ]
    tab = opened(page_with([result._repr_html_() for result in (ks.show(arms[1]), *results)]))
    assert tab.page.locator(".kinestatics:visible").count() == 1 + len(results)
    frame = drawn_scenes(tab, 1)[0]
    for each in (tab.page.main_frame, frame):
        assert each.evaluate("typeof window.RAN") == "undefined"
    tab.assert_quiet()


CANVAS = "[...document.querySelectorAll('canvas')].some(canvas => canvas.width > 100)"


def drawn_scenes(tab, count):
    """The frames of scenes, once they have something to draw on."""
    tab.wait_until(lambda: len(tab.page.frames) == 1 + count)
    for frame in tab.page.frames[1:]:
        frame.wait_for_function(CANVAS, timeout=30_000)
    return tab.page.frames[1:]


def test_scene_is_drawn_without_a_kernel(opened):
    """In a saved page: the canvas shows more than white, the frame reaches neither the page nor anything else."""
    tab = opened(page_with([ks.show(ks.load("puma_560"), height=240)._repr_html_()], "dark"), width=420, height=300)
    (frame,) = drawn_scenes(tab, 1)
    element = tab.page.locator("iframe")
    assert element.bounding_box()["height"] == pytest.approx(242, abs=2)  # and its line above and below
    tab.wait_until(lambda: _dark_pixels(tab, element) > 100, 60.0)
    reached = "() => { try { return parent.document.title } catch (error) { return error.name } }"
    assert frame.evaluate(reached) == "SecurityError"
    tab.assert_quiet()


DARK = """async data => {
  const image = new Image();
  image.src = "data:image/png;base64," + data;
  await image.decode();
  const pen = Object.assign(document.createElement("canvas"), {width: image.width, height: image.height}).getContext("2d");
  pen.drawImage(image, 0, 0);
  const middle = pen.getImageData(image.width / 4, image.height / 4, image.width / 2, image.height / 2).data;
  return middle.filter((value, k) => k % 4 === 0 && value < 170).length;
}"""


def _dark_pixels(tab, element):
    """How many pixels in the middle of what is drawn are far from white."""
    import base64

    return tab.page.evaluate(DARK, base64.b64encode(element.screenshot()).decode())


def test_saved_scene_opens_from_disk(page_of, tmp_path):
    file = ks.show(ks.load("planar_2r"), [0.3, 0.6]).save(tmp_path / "arm.html")
    tab = page_of(f"file://{file}")
    tab.page.wait_for_function(CANVAS, timeout=30_000)
    tab.assert_quiet()


@pytest.mark.slow
def test_several_scenes_in_one_page(opened):
    """Frames do not disturb each other."""
    both = [ks.show(ks.load(name))._repr_html_() for name in ("planar_2r", "scara")]
    assert html.unescape(both[0]) != html.unescape(both[1])
    tab = opened(page_with(both))
    drawn_scenes(tab, 2)
    tab.assert_quiet()
