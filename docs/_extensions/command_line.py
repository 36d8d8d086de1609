"""The reference of the command line, from the commands: their help takes the place of the line `<!-- commands -->`."""

import typer
from cells import fence, prose

from kinestatics.cli.app import app as program

MARK = "<!-- commands -->"


def commands():
    """All of them, by name, in the order of the help."""
    group = typer.main.get_command(program)
    return {name: group.get_command(None, name) for name in group.list_commands(None)}


def help_of(name, command):
    """A command as Markdown: what it does, how it is called, its arguments and its options."""
    context = command.make_context(f"kinestatics {name}", [], resilient_parsing=True)
    parts = [f"## {name}", prose(" ".join((command.help or "").split()))]
    parts.append(fence("text", command.get_usage(context).removeprefix("Usage: ")))
    for parameter in command.get_params(context):
        record = parameter.get_help_record(context)
        if record and "--help" not in record[0]:
            words, help_text = record
            help_text = " ".join(help_text.removesuffix("[required]").split())
            parts.append(f"`{words}`\n: {prose(help_text) or 'as it says'}\n")
    return "\n\n".join(parts)


def fill(app, docname, source):
    """Sphinx's event: a page's text before it is read."""
    del app, docname
    if MARK in source[0]:
        source[0] = source[0].replace(MARK, "\n\n".join(help_of(name, command) for name, command in commands().items()))


def setup(app):
    """Connects the page."""
    app.connect("source-read", fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
