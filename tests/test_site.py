"""The site: its worked examples and commands, what no block of code may escape, and the pages as they are built.

Slow: the whole site is built by scripts/build_docs, warnings as errors; then links, names and pages are looked at.
"""

import functools
import http.server
import importlib.metadata
import os
import re
import shlex
import shutil
import subprocess
import sys
import threading
import time
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

import kinestatics as ks
from browser import browser_fixture, page_of_fixture  # noqa: F401 - fixtures
from kinestatics.cli import main

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
EXAMPLES = sorted(path.stem for path in (ROOT / "examples").glob("[0-9]*.py"))
PAGES = sorted(
    page
    for folder in (DOCS, *DOCS.iterdir())
    if folder.is_dir() and not folder.is_symlink()
    for page in folder.glob("*.md")
    if not page.is_symlink()
)
"""Those that are written for the site: what is in docs/ by a link is tested where it lives."""
LECTURES = sorted((DOCS / "worked_examples").glob("lecture_*.md"))
sys.path.insert(0, str(DOCS / "_extensions"))


# ---- worked examples -----------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def worked():
    """The extension, imported where SymPy is."""
    pytest.importorskip("sympy")
    pytest.importorskip("docutils")
    pytest.importorskip("sphinx")
    import worked_examples

    return worked_examples


@pytest.mark.parametrize("page", LECTURES, ids=lambda page: page.stem)
def test_worked_examples_of_a_lecture_run_and_agree(page, worked):
    """The blocks of a page run from top to bottom, and each value is the answer worked out anew."""
    namespace = worked.fresh()
    found = worked.blocks(page.read_text(encoding="utf-8"))
    assert sum(identifier is not None for identifier, _ in found) >= 4
    for identifier, code in found:
        assert identifier is None or identifier.startswith(page.stem.removeprefix("lecture_"))
        if identifier is None:
            worked.last_value(code, namespace)
        else:
            worked.run(identifier, code, namespace)


def test_a_wrong_value_of_a_worked_example_is_refused(worked):
    """The check can fail: for a sign, for a shape, and for a law that nothing asserts."""
    t2, a1, a2 = worked.sp.symbols("theta2 a1 a2")
    worked.check("000.planar.det", a1 * a2 * worked.sp.sin(t2))
    with pytest.raises(AssertionError):
        worked.check("000.planar.det", -a1 * a2 * worked.sp.sin(t2))
    with pytest.raises(AssertionError, match="is not"):
        worked.check("001.omega", [0, 1])
    with pytest.raises(AssertionError, match="asserts nothing"):
        worked.run("000.planar.sing", "1", {})


def test_every_worked_example_has_its_place(worked):
    """Each of the sixty-nine on one page, and each erratum of a value beside it, once."""
    texts = [page.read_text(encoding="utf-8") for page in LECTURES]
    placed = [identifier for text in texts for identifier, _ in worked.blocks(text) if identifier]
    assert sorted(placed) == sorted(worked.EXAMPLES)
    assert len(placed) == 69
    beside = [name for text in texts for line in re.findall(r"^:errata: (.*)$", text, re.MULTILINE) for name in line.split()]
    assert len(beside) == len(set(beside))
    assert set(beside) <= set(worked.errata()) == {erratum["id"] for erratum in worked.DATA["errata"]}
    wrong = [name for name, example in worked.EXAMPLES.items() if example["notes_agree"] is False]
    blocks = re.findall(r"^```\{worked-example\} (\S+)\n(:errata:)?", "\n".join(texts), re.MULTILINE)
    assert {name for name, errata in blocks if errata} >= set(wrong) - {"003.Jb"}


# ---- code and commands ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_no_python_escapes(page):
    """A block of Python either has prompts, which tests/test_docs.py runs, or is a directive, which the build runs."""
    for block in re.findall(r"^```(?:python|pycon|py)\b.*\n(.*)", page.read_text(encoding="utf-8"), re.MULTILINE):
        assert block.startswith(">>> ")


def commands():
    """The lines of shell blocks that start with the name of the program; the explorer, which waits, has tests of its own."""
    for page in PAGES:
        for block in re.findall(r"^```sh\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL):
            for line in block.replace("\\\n", " ").splitlines():
                command = line.partition("  #")[0].strip()
                if command.startswith("kinestatics ") and command.split()[1] != "explore":
                    yield pytest.param(command, id=f"{page.stem}: {' '.join(command.split())[:40]}")


@pytest.mark.parametrize("command", list(commands()))
def test_commands_run(command, tmp_path, monkeypatch, capsys):
    """Every command of the pages ends well, with the robot file it names at hand."""
    words = shlex.split(command)
    for name in (word for word in words if word.endswith(".urdf")):
        files = importlib.metadata.files("example-robot-data") or []
        wanted = "panda.urdf" if name == "arm.urdf" else name
        source = next((Path(file.locate()) for file in files if str(file).endswith(f"/{wanted}")), None)
        if source is None:
            pytest.skip(f"{wanted} is in the package example-robot-data, which is part of the dev extra")
        shutil.copy(source, tmp_path / name)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", words)
    with pytest.raises(SystemExit) as stopped:
        main()
    out, err = capsys.readouterr()
    assert (stopped.value.code or 0) == 0, err
    assert out.strip() or any(tmp_path.iterdir())


# ---- the extensions ------------------------------------------------------------------------------------------------------


def test_an_example_is_cut_where_it_prints():
    """The cells of an example hold all its code after the docstring, and all it prints."""
    import cells

    path = ROOT / "examples" / "01_what_can_this_arm_do_here.py"
    found = cells.run(path)
    code = "\n\n".join(text for text, _ in found)
    assert re.sub(r"\s+", "", path.read_text(encoding="utf-8")).endswith(re.sub(r"\s+", "", code))
    done = subprocess.run([sys.executable, str(path)], capture_output=True, encoding="utf-8", check=True)
    assert "".join(printed for _, printed in found) == done.stdout


def test_text_of_a_docstring_is_no_markup():
    """Bars, stars, underscores and a bracket at the start stay what they are; laws and errors are set off."""
    pytest.importorskip("docutils")
    import docstrings

    text = "\n".join(
        docstrings.convert(
            [
                "|q̇| of a * b, and J_ too.",
                "",
                "Raises:",
                "    ArrayTypeError: KS302. UnknownNameError:",
                "    KS310, KS318.",
                "",
                "Law: τ = Jᵀ f. Source: MLS.",
                "",
                "    a table",
            ]
        )
    )
    assert r"\|q̇\| of a \* b, and J\_ too." in text
    assert ":py:exc:`UnknownNameError <kinestatics.UnknownNameError>`\n      KS310, KS318." in text
    assert "**Law.** τ = Jᵀ f." in text
    assert "**Source.** MLS." in text
    assert ".. code-block:: text\n\n   a table" in text
    assert docstrings.inline("(n) names") == r"\(n) names"


# ---- the site as it is built ---------------------------------------------------------------------------------------------


def build(folder):
    """Builds the site; the seconds it took."""
    began = time.monotonic()
    done = subprocess.run(
        [str(ROOT / "scripts" / "build_docs"), str(folder)],
        env=os.environ | {"PYTHON": sys.executable},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARNING" not in done.stderr
    return time.monotonic() - began


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site: built once, by whichever worker comes first."""
    for package in ("sphinx", "furo", "myst_parser", "matplotlib", "jax", "torch", "latex2mathml"):
        pytest.importorskip(package)
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "site"
    done, failed = folder.with_suffix(".done"), folder.with_suffix(".failed")
    try:
        folder.with_suffix(".lock").touch(exist_ok=False)
    except FileExistsError:
        while not done.exists():
            assert not failed.exists(), "another worker could not build the site"
            time.sleep(0.5)
    else:
        try:
            build(folder)
        except BaseException:
            failed.touch()
            raise
        done.touch()
    return folder


class Page(HTMLParser):
    """What a page names: ids, links, and what it loads."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.loads, self.maths = set(), [], [], 0
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        self.ids |= {found[key] for key in ("id", "name") if found.get(key)}
        self.maths += tag == "math"
        if tag == "a" and found.get("href"):
            self.links.append(found["href"])
        elif tag == "link" and not {"next", "prev", "index", "search", "canonical"} & set((found.get("rel") or "").split()):
            self.loads.append(found.get("href"))
        self.loads += [found[key] for key in ("src", "data", "poster") if found.get(key)]


@functools.cache
def pages(folder):
    """Every page of the site, by its path."""
    return {
        path.relative_to(folder).as_posix(): Page(path.read_text(encoding="utf-8"))
        for path in sorted(folder.glob("**/*.html"))
    }


@pytest.mark.slow
def test_every_link_leads_somewhere(site):
    """Pages, files and the anchors in them; an address elsewhere is a link to click, of which the reader knows."""
    found, broken = pages(site), []
    assert len(found) > 60
    for name, page in found.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme in ("http", "https", "mailto"):
                continue
            target = (site / name).parent / unquote(parts.path) if parts.path else site / name
            target = target.resolve()
            inside = target.relative_to(site.resolve()).as_posix() if target.is_relative_to(site.resolve()) else None
            anchors = found[inside].ids if inside in found else {parts.fragment}
            if inside is None or not target.exists() or unquote(parts.fragment) not in anchors | {"", "top"}:
                broken.append(f"{name}: {link}")
    assert not broken


@pytest.mark.slow
def test_nothing_is_loaded_from_elsewhere(site):
    """Scripts, styles, pictures and fonts are files of the site, and no style sheet asks for others."""
    for name, page in pages(site).items():
        for address in page.loads:
            assert urlsplit(address).scheme in ("", "data"), f"{name} loads {address}"
            assert not address.startswith("//"), f"{name} loads {address}"
    for sheet in site.glob("**/*.css"):
        assert not re.search(r"url\(\s*[\"']?(https?:)?//|@import", sheet.read_text(encoding="utf-8")), sheet


@pytest.mark.slow
def test_everything_public_has_its_entry(site):
    """Public names and commands in the reference, examples as tutorials, worked examples, errata."""
    found = pages(site)
    reference = set().union(*(page.ids for name, page in found.items() if name.startswith("reference/")))
    public = {f"kinestatics.{name}" for name in ks.__all__} - {"kinestatics.kernels", "kinestatics.plots"}
    assert public | {f"kinestatics.plots.{name}" for name in ks.plots.__all__} <= reference
    import typer

    from kinestatics.cli.app import app

    assert set(typer.main.get_command(app).list_commands(None)) <= found["reference/command_line.html"].ids
    assert {f"tutorials/{name}.html" for name in EXAMPLES} <= set(found)
    import worked_examples

    lectures = [page for name, page in found.items() if name.startswith("worked_examples/lecture")]
    assert sum(identifier.startswith("example-") for page in lectures for identifier in page.ids) == 69
    assert {erratum["id"].lower() for erratum in worked_examples.DATA["errata"]} <= found["errata.html"].ids


@pytest.mark.slow
def test_mathematics_is_mathml_in_its_own_font(site):
    """Formulas of the lectures are MathML, none is left as LaTeX, and no script writes them."""
    found = pages(site)
    assert sum(page.maths for page in found.values()) > 80
    assert (site / "_static" / "mathematics.woff2").stat().st_size > 10_000
    assert 'url("mathematics.woff2")' in (site / "_static" / "site.css").read_text(encoding="utf-8")
    text = "".join(path.read_text(encoding="utf-8") for path in site.glob("**/*.html"))
    assert not re.search(r"mathjax(?!_ignore)", text.lower())  # the class with which MyST keeps it off
    assert r"\begin{bmatrix}" not in re.sub(r"<pre>.*?</pre>", "", text, flags=re.DOTALL)


@pytest.mark.slow
def test_examples_print_into_their_pages(site):
    """What the first example prints stands on its page, line by line."""
    import html

    example = ROOT / "examples" / "01_what_can_this_arm_do_here.py"
    done = subprocess.run([sys.executable, str(example)], capture_output=True, encoding="utf-8", check=True)
    page = html.unescape(re.sub(r"<[^>]+>", "", (site / "tutorials" / f"{example.stem}.html").read_text(encoding="utf-8")))
    for line in done.stdout.splitlines():
        assert line.strip() in page


@pytest.fixture(scope="module")
def address(site):
    """The site on loopback."""

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def __init__(self, *arguments):
            super().__init__(*arguments, directory=str(site))

        def log_message(self, *_):
            """Says nothing."""

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Quiet) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_address[1]}"
        server.shutdown()


@pytest.mark.slow
def test_every_page_is_quiet_in_a_browser(site, address, page_of):
    """No error on the console, nothing missing, nothing asked of anyone else, and nothing wider than a narrow window."""
    tab, wide, missing = page_of(width=400, height=800), [], []
    tab.page.on("response", lambda response: response.status >= 400 and missing.append(response.url))
    for name in pages(site):
        tab.page.goto(f"{address}/{name}")
        if tab.page.evaluate("document.documentElement.scrollWidth > window.innerWidth + 1"):
            wide.append(name)
    assert not missing
    assert not wide
    tab.assert_quiet()


@pytest.mark.slow
def test_search_finds_a_name(address, page_of):
    """By the site's own index, with nobody else asked."""
    tab = page_of(f"{address}/search.html?q=manipulability")
    tab.wait_until(lambda: tab.page.locator("#search-results ul.search li").count() >= 3)
    assert "reference/dexterity.html" in " ".join(
        tab.page.locator("#search-results a").evaluate_all("links => links.map(link => link.href)")
    )
    tab.assert_quiet()


@pytest.mark.nightly
def test_the_same_sources_make_the_same_bytes(site, tmp_path):
    """A second build is the first, byte by byte, and takes three minutes at most of one processor's time."""
    again, before = tmp_path / "site", os.times()
    build(again)
    after = os.times()
    assert after.children_user - before.children_user < 180
    names = sorted(path.relative_to(again) for path in again.glob("**/*") if path.is_file())
    assert names == sorted(path.relative_to(site) for path in site.glob("**/*") if path.is_file())
    assert not [name for name in names if (again / name).read_bytes() != (site / name).read_bytes()]
