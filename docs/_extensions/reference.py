"""The reference: every public name of the package, on the page of its group, from its docstring.

    ```{names} statics
    ```

lists the public names that live in a module, or below it; `plots` lists the pictures. A public name that is on no page, or
on two, is a warning, and so an error.
"""

import inspect
import re

from docstrings import inline
from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.util import logging

import kinestatics as ks

HOMES = {name: module for module, names in ks._CONTENTS.items() for name in names}
FOLDERS = {"kernels": "_kernels", "plots": "plots"}
BASES = "Exception, Warning, object, dict, tuple, Mapping"


def names_of(module):
    """The public names of a module and those below it, in the order of the contents."""
    return [name for name, home in HOMES.items() if home == module or home.startswith(f"{module}.")]


def summary(thing):
    """The first paragraph's first sentence of a docstring."""
    text = re.split(r"\n\s*\n", inspect.getdoc(thing) or "")[0].replace("\n", " ")
    return re.split(r"(?<=[.?!]) (?=[A-Z])", text)[0]


def entry(name, thing):
    """The autodoc directive of a name."""
    if inspect.isclass(thing):
        more = "" if issubclass(thing, BaseException) else f"\n   :inherited-members: {BASES}"
        return f".. autoclass:: {name}\n   :members:{more}"
    return f".. autofunction:: {name}" if callable(thing) else f".. autodata:: {name}\n   :no-value:"


class Names(Directive):
    """The directive `names`: a table of what is there, then the entries."""

    optional_arguments = 100
    has_content = False

    def run(self):
        """Parses the table and the entries as reStructuredText."""
        environment = self.state.document.settings.env
        things = {}
        for module in self.arguments:
            if module == "plots":
                things |= {f"kinestatics.plots.{name}": getattr(ks.plots, name) for name in ks.plots.__all__}
            else:
                things |= {f"kinestatics.{name}": getattr(ks, name) for name in names_of(module)}
        if not things:
            return []
        things = dict(
            sorted(things.items(), key=lambda item: inspect.isclass(item[1]))
        )  # what one calls, then what comes back
        seen = environment.__dict__.setdefault("kinestatics_names", {})
        seen.setdefault(environment.docname, []).extend(things)
        table = [".. list-table::", "   :class: summary", "   :widths: auto", ""]
        for name, thing in things.items():
            table += [f"   * - :py:obj:`{name.rpartition('.')[2]} <{name}>`", f"     - {inline(summary(thing))}"]
        text = "\n\n".join(["\n".join(table), *(entry(name, thing) for name, thing in things.items())])
        node = nodes.container()
        self.state.nested_parse(["````{eval-rst}", *text.splitlines(), "````"], self.lineno, node)
        return node.children


def forget(app, environment, docname):
    """A page that is read anew, or gone, has no names."""
    del app
    environment.__dict__.setdefault("kinestatics_names", {}).pop(docname, None)


def check(app, environment):
    """Every public name is on one page."""
    del app
    pages = environment.__dict__.get("kinestatics_names", {}).values()
    listed = [name for names in pages for name in names]
    wanted = {f"kinestatics.{name}" for name in HOMES} | {f"kinestatics.plots.{name}" for name in ks.plots.__all__}
    for name in sorted(wanted):
        if listed.count(name) != 1:
            logging.getLogger(__name__).warning("%s is on %d pages of the reference", name, listed.count(name))


def signature_of(app, what, name, obj, options, signature, return_annotation):
    """What a function returns is shown where it is a public class; how to make a result is not: functions make it."""
    del app, name, options, return_annotation
    if what == "class" and not getattr(getattr(obj, "__dataclass_params__", None), "eq", True):
        return ("", None)
    if what not in ("function", "method") or not signature:
        return None
    word = str(getattr(obj, "__annotations__", {}).get("return", "")).strip("\"'")
    return (signature, f"kinestatics.{word}") if word in HOMES else None


def setup(app):
    """Registers the directive and the check."""
    app.add_directive("names", Names)
    app.connect("autodoc-process-signature", signature_of)
    app.connect("env-purge-doc", forget)
    app.connect("env-check-consistency", check)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
