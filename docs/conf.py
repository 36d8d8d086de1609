"""The site: MyST pages, tutorials that are the examples, a reference that is the docstrings. Built by scripts/build_docs.

Three entries of this folder are links to where the text lives: tutorials to examples/, benchmarks, and changelog.md.
Nothing is fetched while it is built, and nothing while it is read.
"""

import importlib.metadata
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "kinestatics"
author = "The kinestatics founders"
project_copyright = author
version = release = importlib.metadata.version("kinestatics")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "docstrings",
    "reference",
    "command_line",
    "linked",
    "mathematics",
    "pictures",
    "tutorials",
    "worked_examples",
]
source_suffix = {".md": "markdown", ".py": "example"}
include_patterns = ["*.md", "[!_]*/*.md", "tutorials/[0-9]*.py"]
exclude_patterns = ["tutorials/README.md"]
nitpicky = True

myst_enable_extensions = ["colon_fence", "dollarmath", "deflist", "attrs_inline"]
myst_heading_anchors = 3

autodoc_typehints = "none"  # shapes, units and frames are in the docstrings, where a type cannot say them
autodoc_member_order = "bysource"
add_module_names = False
python_use_unqualified_type_names = True
smartquotes = False  # "pseudoinverse" is a string, and -- an option
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = "kinestatics"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_favicon = "_static/mark.svg"
html_logo = "_static/mark.svg"
html_math_renderer = "mathml"
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_last_updated_fmt = None
pygments_style = "friendly"
pygments_dark_style = "github-dark"
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#0072B2",
        "color-brand-content": "#0072B2",
        "color-brand-visited": "#0072B2",
        "color-force": "#B84F00",
    },
    "dark_css_variables": {
        "color-brand-primary": "#6CC0F0",
        "color-brand-content": "#6CC0F0",
        "color-brand-visited": "#6CC0F0",
        "color-force": "#F5924E",
    },
}
