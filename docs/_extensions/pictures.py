"""Pictures made while the site is built, by the package itself.

    ```{picture} What a reader who cannot see it should know
    :caption: What it shows
    ks.plots.velocity_ellipsoid(ks.load("planar_2r"), [0.4, 0.9])
    ```

The last line of the code is a picture: axes or a figure. With `:code:` the code is shown above it.
"""

import hashlib
import io
from pathlib import Path

from cells import last_value
from docutils import nodes
from docutils.parsers.rst import Directive, directives

import kinestatics as ks

FOLDER = "_images"


class picture(nodes.General, nodes.Element):
    """An image of the build: `file` in the site's folder of images, `alt`, and a caption or none."""


def svg(code):
    """The picture that some lines of Python make, as SVG: the same bytes whenever it is made."""
    import matplotlib
    from matplotlib import pyplot

    matplotlib.use("agg")
    with matplotlib.rc_context({"svg.hashsalt": "kinestatics", "svg.fonttype": "path"}):
        drawn = last_value(code, {"ks": ks})
        figure, page = getattr(drawn, "figure", drawn), io.BytesIO()
        figure.savefig(page, format="svg", metadata={"Date": None}, bbox_inches="tight", transparent=False)
        pyplot.close(figure)
    return page.getvalue()


class Picture(Directive):
    """The directive `picture`."""

    has_content = True
    required_arguments = 1
    final_argument_whitespace = True
    option_spec = {"caption": directives.unchanged, "code": directives.flag, "class": directives.class_option}  # noqa: RUF012

    def run(self):
        """The code if it is to be shown, and the picture."""
        code = "\n".join(self.content)
        environment = self.state.document.settings.env
        name = f"picture-{hashlib.sha256(code.encode()).hexdigest()[:12]}.svg"
        folder = Path(environment.app.outdir) / FOLDER
        folder.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(svg(code))
        made = picture(file=name, alt=self.arguments[0], classes=self.options.get("class", []))
        if "caption" in self.options:
            words, messages = self.state.inline_text(self.options["caption"], self.lineno)
            made += [nodes.caption("", "", *words), *messages]
        shown = [nodes.literal_block(code, code, language="python")] if "code" in self.options else []
        return [*shown, made]


def _open(self, node):
    """The image, and its caption below."""
    source = f"{self.builder.imgpath}/{node['file']}"
    classes = " ".join(["picture", *node["classes"]])
    alt = self.attval(node["alt"])
    self.body.append(f'<figure class="{classes}"><img src="{source}" alt="{alt}" loading="lazy">')
    if node.children:
        self.body.append("<figcaption>")


def _close(self, node):
    self.body.append("</figcaption></figure>\n" if node.children else "</figure>\n")


def setup(app):
    """Registers the directive and its node."""
    app.add_node(picture, html=(_open, _close))
    app.add_directive("picture", Picture)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
