"""The worked examples of the lectures: each a call whose value is computed when the page is built, and checked.

    ```{setup}
    arm = ks.load("planar_2r")
    ```

    ```{worked-example} 000.planar.det
    :errata: E000-2
    sp.Matrix(ks.jacobian(arm, [t1, t2]).linear[:2]).det()
    ```

The blocks of a page run from top to bottom in one namespace. The value of the last line is compared, at three sets of
random numbers, with the answer in tests/golden/worked_examples.json; where that is a set or a law, the code asserts it.
"""

import json
import re
from pathlib import Path

import numpy as np
import sympy as sp
from cells import last_value
from docutils import nodes
from docutils.parsers.rst import Directive, directives
from sphinx.errors import ExtensionError

import kinestatics as ks

DOCS = Path(__file__).parents[1]
DATA = json.loads((DOCS.parent / "tests" / "golden" / "worked_examples.json").read_text(encoding="utf-8"))
EXAMPLES = {example["id"]: example for example in DATA["examples"]}
LENGTHS = {"L1": sp.Rational(7, 10), "L2": sp.Rational(2, 5)}
"""Of the arm of lecture 003, which is known at numbers only."""


# ---- values ----------------------------------------------------------------------------------------------------------


def is_argued(identifier):
    """Whether the answer is a set or a law, which the code of the page asserts; else it is a value, compared here."""
    expected, kind = EXAMPLES[identifier]["expected"], EXAMPLES[identifier]["kind"]
    return isinstance(expected, dict) or "=" in str(expected) or (isinstance(expected, str) and kind != "example")


def entries(value):
    """A quantity, matrix, list or expression as an array of expressions; units such as "N m" dropped."""
    array = np.array(getattr(value, "array", value), dtype=object)
    flat = [sp.sympify(re.sub(r" N( m)?$", "", str(x)) if isinstance(x, str) else x) for x in np.ravel(array)]
    return np.array(flat, dtype=object).reshape(array.shape)


def at_numbers(array, numbers):
    return np.array([float(x.subs(numbers).evalf(30)) for x in np.ravel(array)]).reshape(array.shape)


def check(identifier, value):
    """Whether a value is the answer, at three sets of random numbers.

    Raises:
        AssertionError: if it is not.
    """
    found, right = entries(value), entries(EXAMPLES[identifier]["expected"])
    assert found.shape == right.shape, f"{identifier}: {found.shape} is not {right.shape}"
    symbols = sorted({s for x in [*np.ravel(found), *np.ravel(right)] for s in x.free_symbols}, key=str)
    rng = np.random.default_rng(4)
    for _ in range(3):
        numbers = {s: LENGTHS.get(str(s), sp.Rational(int(rng.integers(1, 999)), 500)) for s in symbols}
        np.testing.assert_allclose(at_numbers(found, numbers), at_numbers(right, numbers), rtol=1e-12, atol=1e-12)


def run(identifier, code, namespace):
    """The value of an example's code, checked."""
    value = last_value(code, namespace, identifier)
    if is_argued(identifier):
        assert re.search(r"\bassert\b", code), f"{identifier} asserts nothing"
    else:
        check(identifier, value)
    return value


def fresh():
    """The names a page starts with."""
    return {"ks": ks, "np": np, "sp": sp}


def blocks(page):
    """The blocks of a page: (identifier or None for a setup, code), without options."""
    found = re.finditer(r"^```\{(setup|worked-example)\} ?(\S*)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    return [(match[2] or None, re.sub(r"^:\w+:.*\n", "", match[3], flags=re.MULTILINE)) for match in found]


def latex(value):
    """A value as mathematics."""
    value = getattr(value, "array", value)
    if isinstance(value, bool | np.bool_ | str):
        return rf"\text{{{value}}}"
    array = np.array(value, dtype=object)
    short = np.array([_tidy(x) for x in np.ravel(array)], dtype=object).reshape(array.shape)
    if array.ndim == 1:
        short = short.reshape(-1, 1)
    text = ks.to_latex(sp.Matrix(short) if array.ndim else short.item())
    return re.sub(r"\\mathrm\{theta(d?)dot\}", lambda match: r"\d" + match[1] + r"ot{\theta}", text)


def _tidy(x):
    """Exact expressions in their shortest form; measured numbers to six digits."""
    x = sp.sympify(x)
    if x.atoms(sp.Float):
        number = sp.nsimplify(sp.Float(f"{float(x):.6g}")) if x.is_number and float(x) == round(float(x), 12) else x
        return number if number.is_Integer else sp.Float(f"{float(x):.6g}", 6) if x.is_number else x
    return sp.simplify(x)


# ---- errata ----------------------------------------------------------------------------------------------------------


def errata():
    """What docs/errata.md says of each erratum: (printed, right), as Markdown."""
    page, found = (DOCS / "errata.md").read_text(encoding="utf-8"), {}
    for match in re.finditer(r"^\| (E\d+-\d+) \| (.*?) \| (.*) \|$", page, re.MULTILINE):
        found[match[1]] = (match[2], match[3])
    for part in re.split(r"^(?=#+ |\*\*E\d)", page, flags=re.MULTILINE):
        title = part.partition("\n")[0] if part.startswith("#") else part.partition("**")[2].partition("**")[0]
        words = re.search(r"Printed: (.*?)\s+Right: (.*?)(?:\n\n|$)", part, re.DOTALL)
        for identifier in re.findall(r"E\d{3}-\d+", title) if words else ():
            found[identifier] = (_line(words[1]), _line(words[2]))
    return found


def _line(text):
    return " ".join(text.split()).removesuffix(".").removesuffix(":") + "."


def give_anchors(app, document):
    """Gives each entry of the page of errata (a heading, a bold beginning, a row) an id, so that others can point at it."""
    if app.env.docname != "errata":
        return
    for node in document.findall(lambda node: isinstance(node, nodes.section | nodes.paragraph)):
        bold = next(iter(node.findall(nodes.strong)), None)
        if isinstance(node, nodes.section):
            text, place = node[0].astext(), node
        elif bold is not None and node.astext().startswith(bold.astext()):
            text, place = bold.astext(), node
        elif isinstance(node.parent, nodes.entry) and node.parent.parent.index(node.parent) == 0:
            text, place = node.astext(), node.parent.parent
        else:
            continue
        place["ids"] = place["ids"] + [name.lower() for name in re.findall(r"\bE\d{3}-\d+\b", text)]


# ---- directives ------------------------------------------------------------------------------------------------------


class Block(Directive):
    """What the two directives share: the namespace of the page."""

    has_content = True

    @property
    def namespace(self):
        """Made anew for each page."""
        return self.state.document.settings.env.current_document.setdefault("worked_examples", fresh())

    def listing(self):
        code = "\n".join(self.content)
        return code, nodes.literal_block(code, code, language="python")

    def parsed(self, lines):
        """Nodes of some Markdown."""
        node = nodes.Element()
        self.state.nested_parse(lines, self.content_offset, node)
        return node.children


class Setup(Block):
    """The directive `setup`: names that the examples below it use."""

    def run(self):
        """Runs and shows the code."""
        code, shown = self.listing()
        last_value(code, self.namespace, "setup")
        return [shown]


class WorkedExample(Block):
    """The directive `worked-example`: the call, its value, and what the lecture printed wrongly."""

    required_arguments = 1
    option_spec = {"errata": directives.unchanged}  # noqa: RUF012

    def run(self):
        """Runs, checks and shows."""
        identifier = self.arguments[0]
        code, shown = self.listing()
        try:
            value = run(identifier, code, self.namespace)
        except Exception as error:
            raise ExtensionError(f"worked example {identifier}: {error}", error) from error
        box = nodes.container(classes=["worked"], ids=[nodes.make_id(f"example-{identifier}")])
        box += shown
        if value is not None:
            text = latex(value)
            box += nodes.math_block(text, text, nowrap=True, number=None, label=None)
        how = "holds as asserted" if is_argued(identifier) else "agrees with the answer worked out anew"
        box += nodes.paragraph("", "", nodes.literal("", identifier), nodes.Text(f" {how}"), classes=["checked"])
        known = errata()
        for name in self.options.get("errata", "").split():
            printed, right = known[name]
            title = f"::::{{admonition}} Erratum {{erratum}}`{name}`"
            box += self.parsed([title, ":class: erratum", "", f"Printed: {printed}", "", f"Right: {right}", "::::"])
        return [box]


def erratum(name, rawtext, text, lineno, inliner, options=None, content=()):
    """The role `erratum`: a link to its entry on the page of errata."""
    del name, lineno, options, content
    depth = inliner.document.settings.env.docname.count("/")
    return [nodes.reference(rawtext, text, refuri=f"{'../' * depth}errata.html#{text.lower()}", internal=True)], []


class Errata(Block):
    """The directive `errata`: a list of all errata of a lecture, such as 000, each a link to its entry."""

    required_arguments = 1
    has_content = False

    def run(self):
        """One item each."""
        lines = []
        for name, (printed, right) in sorted(errata().items()):
            if name.startswith(f"E{self.arguments[0]}-"):
                lines += [f"- {{erratum}}`{name}` {printed} *Right:* {right}", ""]
        return self.parsed(lines)


def setup(app):
    """Registers directives and anchors."""
    app.add_directive("setup", Setup)
    app.add_directive("worked-example", WorkedExample)
    app.add_directive("errata-of", Errata)
    app.add_role("erratum", erratum)
    app.connect("doctree-read", give_anchors)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
