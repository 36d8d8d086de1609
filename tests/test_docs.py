"""docs/*.md, executed: the `>>>` blocks of a page run from top to bottom in one namespace and print what the page says.

Then what docs/errata.md must hold, and the pictures of the examples that go with the lectures.
"""

import doctest
import json
import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[1]
PAGES = sorted(page for page in (ROOT / "docs").glob("**/*.md") if ">>> " in page.read_text(encoding="utf-8"))
ERRATA = json.loads((Path(__file__).parent / "golden" / "worked_examples.json").read_text(encoding="utf-8"))["errata"]
ARGUED = {"math", "sign/convention", "convention", "index", "units", "rounding", "incomplete", "caveat", "wording"}
"""Kinds of erratum that a call proves; typo, ocr and notation are cosmetic."""


def blocks(text):
    """The fenced Python blocks that hold prompts, each with the number of lines before it."""
    found = re.finditer(r"^```python\n(>>> .*?)^```$", text, re.MULTILINE | re.DOTALL)
    return [(text[: match.start(1)].count("\n"), match[1]) for match in found]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_blocks_print_what_the_page_says(page):
    """Each output is compared character by character, but for runs of spaces."""
    text = page.read_text(encoding="utf-8")
    assert text.count("\n>>> ") == sum(1 + block.count("\n>>> ") for _, block in blocks(text)), "a prompt outside a block"
    for package in ("sympy", "jax", "torch", "pinocchio", "mujoco"):
        if f"import {package}" in text:
            pytest.importorskip(package)
    if "ks.singularities(" in text or "singularities=True" in text:
        pytest.importorskip("flint")
    if '"qp"' in text or "RateSolver(" in text:
        pytest.importorskip("daqp")
    namespace = {"__name__": page.stem}
    runner = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
    report = []
    with np.printoptions():  # what a page sets does not outlive it
        for line, block in blocks(text):
            example = doctest.DocTestParser().get_doctest(block, namespace, page.name, str(page), line)
            runner.run(example, out=report.append, clear_globs=False)
            namespace = example.globs
    assert runner.failures == 0, "".join(report)


# ---- docs/errata.md ------------------------------------------------------------------------------------------------------

PAGE = (ROOT / "docs" / "errata.md").read_text(encoding="utf-8")


def places(identifier):
    """Where an erratum has its entry: a heading, a bold first line or a row of a table; not where it is mentioned."""
    return [
        match.start()
        for match in re.finditer(r"^(?:#+ .*|\*\*.*?\*\*|\| E\d+-\d+ \|).*$", PAGE, re.MULTILINE)
        if re.search(rf"\b{identifier}\b", re.match(r"#+ .*|\*\*.*?\*\*|\|.*?\|", match[0])[0])
    ]


def test_there_are_thirty_one():
    """The page says so."""
    assert len(ERRATA) == 31
    assert PAGE.startswith("# Errata of the lecture notes\n\nThirty-one ")


@pytest.mark.parametrize("erratum", ERRATA, ids=lambda erratum: erratum["id"])
def test_every_erratum_has_one_entry_and_a_call_that_proves_it(erratum):
    """One entry each; a call below it unless the slip is one of type, notation or conversion to text."""
    (start,) = places(erratum["id"])
    if erratum["kind"] in ARGUED:
        entry = re.split(r"^(?:#|\*\*)", PAGE[start:].lstrip("#*"), maxsplit=1, flags=re.MULTILINE)[0]
        assert "```python\n>>> " in entry
        assert "Printed: " in entry
        assert "Right: " in entry


def test_every_kind_of_erratum_is_known():
    """A new kind must be sorted into those with a call and those without."""
    assert {erratum["kind"] for erratum in ERRATA} == ARGUED | {"typo", "ocr", "notation"}


# ---- the examples that go with the lectures ------------------------------------------------------------------------------

LECTURES = sorted(path for path in (ROOT / "examples").glob("*.py") if re.match(r"\d\d_(lecture|lab)_", path.name))


@pytest.mark.parametrize("path", LECTURES, ids=lambda path: path.stem)
def test_lecture_example_draws_its_picture_into_a_folder(path, tmp_path, monkeypatch, capsys):
    """Given a folder, an example leaves its pictures there, and prints what it prints without."""
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(sys, "argv", [str(path)])
    runpy.run_path(str(path), run_name="__main__")
    alone = capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", [str(path), str(tmp_path)])
    runpy.run_path(str(path), run_name="__main__")
    assert capsys.readouterr().out == alone
    assert {picture.suffix for picture in tmp_path.iterdir()} == {".png"}


def test_every_lecture_has_an_example():
    """Five lectures and the lab."""
    assert [re.sub(r"^\d\d_", "", path.stem)[:11] for path in LECTURES] == [
        *(f"lecture_00{k}" for k in range(5)),
        "lab_forward",
    ]
