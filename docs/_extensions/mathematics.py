"""Mathematics as MathML, by the converter of the reports and in their font: no script, nothing from elsewhere."""

from importlib import resources

from docutils import nodes
from sphinx.util import logging

from kinestatics.report.mathematics import FONT, mathml


def _written(node, display):
    """MathML; a warning, and so an error, where the formula is beyond the converter."""
    written = mathml(node.astext(), display)
    if not written.startswith("<math"):
        logging.getLogger(__name__).warning("no MathML for %s", node.astext(), location=node)
    return written


def _inline(self, node):
    """A formula in a line."""
    self.body.append(_written(node, display=False))
    raise nodes.SkipNode


def _block(self, node):
    """A formula of its own, which scrolls in its own box where it is wide."""
    written = _written(node, display=True)
    self.body.append(f'<div class="formula" tabindex="0" role="group" aria-label="Formula">{written}</div>\n')
    raise nodes.SkipNode


def setup(app):
    """Registers the renderer, and brings the font along."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.config.html_static_path.append(str(resources.files("kinestatics.report") / "fonts" / FONT))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
