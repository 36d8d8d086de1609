"""Pages that are in docs/ by a symbolic link, so that nothing is copied: examples, benchmarks, changes."""

from pathlib import Path

from sphinx import addnodes


def follow_links(app, document):
    """A link to such a file where it lives, such as ../examples/01_....py, means the page it makes."""
    pages = {str(Path(app.env.doc2path(name)).resolve().with_suffix("")): name for name in app.env.found_docs}
    for link in document.findall(addnodes.pending_xref):
        link["reftarget"] = pages.get(link["reftarget"], link["reftarget"])


def give_title(app, docname, source):
    """A table of measurements that has no title is called as its file."""
    del app
    if docname.startswith("benchmarks/") and not source[0].startswith("# "):
        name = docname.rpartition("/")[2].replace("_", " ")
        source[0] = f"# {name[0].upper()}{name[1:]}\n\n{source[0]}"


def setup(app):
    """Connects both."""
    app.connect("doctree-read", follow_links)
    app.connect("source-read", give_title)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
