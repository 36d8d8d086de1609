"""Each example is a page: its question, its text, its law, its code with what it printed, and the pictures it drew.

The parser of `.py` sources. All examples to be read are run before the first is, two at a time, each in its own process.
"""

import ast
import json
import os
import re
import struct
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from cells import __file__ as runner, fence, prose
from docutils import nodes
from docutils.parsers.rst import Directive
from myst_parser.parsers.sphinx_ import MystParser
from pictures import FOLDER, picture
from sphinx.errors import ExtensionError

TIME = re.compile(r"^(.*?)[ \d]+ ns each, [\d.]+ s in all$", re.MULTILINE)
"""What no two runs print alike."""


def example_of(environment, docname):
    """The file behind a page, or None where the page is no example."""
    path = Path(environment.doc2path(docname))
    return path if path.suffix == ".py" else None


def run(path, images):
    """Runs an example, warnings as errors; its cells, and the names its pictures got in the folder of images."""
    with tempfile.TemporaryDirectory() as folder:
        pictures, out = Path(folder) / "pictures", Path(folder) / "cells.json"
        done = subprocess.run(
            [sys.executable, "-W", "error", runner, str(path), str(pictures), str(out)],
            capture_output=True,
            encoding="utf-8",
            env=os.environ | {"PYTHONUTF8": "1", "JAX_PLATFORMS": "cpu", "MPLBACKEND": "agg", "COLUMNS": "100"},
            check=False,
        )
        if done.returncode:
            raise ExtensionError(f"{path} failed:\n{done.stderr}")
        drawn = sorted(pictures.glob("*.png"), key=lambda file: file.stat().st_mtime_ns)
        images.mkdir(parents=True, exist_ok=True)
        names = []
        for file in drawn:
            names.append(f"{path.stem}-{file.stem}.png")
            (images / names[-1]).write_bytes(file.read_bytes())
        return {"cells": json.loads(out.read_text(encoding="utf-8")), "pictures": names}


def run_all(app, environment, docnames):
    """Runs the examples among the pages to be read."""
    found = {name: path for name in docnames if (path := example_of(environment, name))}
    images = Path(app.outdir) / FOLDER
    with ThreadPoolExecutor(max_workers=min(2, os.cpu_count() or 1)) as pool:
        results = pool.map(lambda path: run(path, images), found.values())
        app.examples_run = dict(zip(found, results, strict=True))


def linked(text):
    """Names of errata and of pages as links."""
    text = re.sub(r"\bE\d{3}-\d+\b", lambda match: f"{{erratum}}`{match[0]}`", text)
    return re.sub(r"\bdocs/((\w+)\.md)", r"[\2](/\1)", text)


def page(path, cells, pictures):
    """The page of an example, as MyST."""
    title, *rest = [
        linked(prose(part)) for part in ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))).split("\n\n")
    ]
    parts = [f"# {title}"]
    for part in rest:
        law = part.removeprefix("Law: ")
        parts.append(part if law == part else f":::{{admonition}} Law\n:class: law\n\n{law[0].upper()}{law[1:]}\n:::")
    if len(pictures) == 1:
        parts.append(fence("{drawn}", pictures[0]))
    for code, printed in cells:
        parts.append(fence("python", code))
        if printed:
            parts.append(":::{div} printed\n" + fence("text", TIME.sub(r"\1      … ns each", printed.strip("\n"))) + "\n:::")
    if len(pictures) > 1:
        parts += ["## Pictures", fence("{drawn}", "\n".join(pictures))]
    if any(TIME.search(printed) for _, printed in cells):
        parts.append(
            "Times differ from machine to machine and are left out here; [benchmarks](../benchmarks/README.md) has some."
        )
    folder = " pictures/" if pictures else ""
    parts.append(
        f":::{{div}} source\nThis page is `examples/{path.name}` as it ran when the site was built. "
        f"Run it: `python examples/{path.name}{folder}`.\n:::"
    )
    return "\n\n".join(parts) + "\n"


class ExampleParser(MystParser):
    """Reads an example as the page it makes."""

    supported = ("example",)

    def parse(self, inputstring, document):
        """Writes the page and reads that."""
        del inputstring
        environment = document.settings.env
        path, result = example_of(environment, environment.docname), environment.app.examples_run[environment.docname]
        super().parse(page(path, result["cells"], result["pictures"]), document)


class Drawn(Directive):
    """The pictures of an example, one a line."""

    has_content = True

    def run(self):
        """One node each, with its size, so that the page does not jump when it is read."""
        names = list(self.content)
        folder = Path(self.state.document.settings.env.app.outdir) / FOLDER
        group = nodes.container(classes=["pictures"] if len(names) > 1 else [])
        for name in names:
            width, _ = struct.unpack(">II", (folder / name).read_bytes()[16:24])
            words = name.removesuffix(".png").partition("-")[2].replace("_", " ")
            wide = ["wide"] if width > 1400 else []
            caption = [nodes.caption("", words)] if len(names) > 1 else []
            group += picture("", *caption, file=name, alt=f"Drawn by this example: {words}", classes=wide)
        return [group]


class Tutorials(Directive):
    """The list of all examples, with their questions."""

    def run(self):
        """A numbered list of links."""
        environment = self.state.document.settings.env
        rows = nodes.bullet_list(classes=["tutorials"])
        for docname in sorted(name for name in environment.found_docs if example_of(environment, name)):
            title = ast.get_docstring(ast.parse(example_of(environment, docname).read_text(encoding="utf-8"))).splitlines()[
                0
            ]
            number = nodes.strong("", docname.rpartition("/")[2][:2])
            uri = f"{docname.rpartition('/')[2]}.html" if "/" in environment.docname else f"{docname}.html"
            link = nodes.reference("", title, refuri=uri, internal=True)
            rows += nodes.list_item("", nodes.paragraph("", "", number, nodes.Text(" "), link))
        return [rows]


class Div(Directive):
    """A part of a page with a class of its own."""

    has_content = True
    required_arguments = 1

    def run(self):
        """The content, in a container."""
        node = nodes.container(classes=self.arguments[0].split())
        self.state.nested_parse(self.content, self.content_offset, node)
        return [node]


def setup(app):
    """Registers the parser, the directives and the runs before reading."""
    app.add_source_parser(ExampleParser)
    app.connect("env-before-read-docs", run_all)
    app.add_directive("drawn", Drawn)
    app.add_directive("tutorials", Tutorials)
    app.add_directive("div", Div)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
