"""The house's docstrings as reStructuredText: sections with indented bodies, laws, bars and stars that are no markup.

    Args: Attributes: Methods: Raises:    lists of definitions
    Returns: Example:                     a field; a block of code
    Law: ... Source: ...                  paragraphs, set off

`code` in single backticks is a link where it is a public name. An indented block in the text is shown as it stands.
"""

import re
import textwrap

import kinestatics as ks

HEADER = re.compile(r"^(Args|Attributes|Methods|Returns|Yields|Raises|Warns|Example|Examples):$")
TITLES = {"Args": "Arguments", "Attributes": "Attributes", "Methods": "Methods", "Returns": "Returns", "Yields": "Yields"}
ASIDE = re.compile(r"(?:^|(?<=[.;)]\s))(Laws?|Source|Sources): ")
ERROR = re.compile(r"(?:^|(?<=[.,;]\s))(?=[A-Z]\w*(?:Error|Warning)\b)")


def inline(text):
    """Text of a line: `code` becomes code or a link, everything else is literal."""
    parts = re.split(r"(``[^`]+``|`[^`]+`)", text)
    out = "".join(_code(part.strip("`")) if part.startswith("`") else _literal(part) for part in parts)
    return re.sub(r"^(\(?\w+[.)] |[-+•] )", r"\\\1", out)  # "(n) names" begins no list


def _code(text):
    name = text.removesuffix("()").removeprefix("ks.")
    if name in ks.__all__:
        return f"\\ :py:obj:`{text} <kinestatics.{name}>`\\ "
    return f"\\ ``{text}``\\ "


def _literal(text):
    return re.sub(r"[\\*|`]|(?<=\w)_(?!\w)|(?<=\w):(?=\S)", lambda match: "\\" + match[0], text)


def blocks(lines):
    """Paragraphs and indented blocks: (indented, lines)."""
    found, current = [], []
    for line in [*lines, ""]:
        if line.strip():
            current.append(line)
        elif current:
            indented = all(text.startswith(" ") for text in current)
            if found and indented and found[-1][0]:
                found[-1][1].extend(["", *current])
            else:
                found.append((indented, current))
            current = []
    return found


def paragraphs(lines):
    """Running text: paragraphs, indented blocks as they stand, `>>>` as doctest blocks, laws and sources set off."""
    out = []
    for indented, block in blocks(lines):
        if block[0].lstrip().startswith(">>> "):
            out += [".. code-block:: pycon", "", *textwrap.indent(textwrap.dedent("\n".join(block)), "   ").splitlines(), ""]
        elif indented:
            out += [".. code-block:: text", "", *textwrap.indent(textwrap.dedent("\n".join(block)), "   ").splitlines(), ""]
        else:
            out += _text(block)
    return out


def _text(block):
    """A paragraph, in which a list, a law or a source may begin."""
    for number, line in enumerate(block):
        if number and line.startswith(("    ", "  ")) and block[number - 1].rstrip().endswith(":"):
            return [*_text(block[:number]), *paragraphs(block[number:])]
    text = " ".join(line.strip() for line in block)
    head, *pairs = ASIDE.split(text)
    out = [inline(head.strip()), ""] if head.strip() else []
    for title, body in zip(pairs[::2], pairs[1::2], strict=True):
        out += [f".. container:: aside {title.rstrip('s').lower()}", "", f"   **{title}.** {inline(body.strip())}", ""]
    return out


def entries(lines):
    """`name: text` of a section's body, with its further lines."""
    found = []
    for line in textwrap.dedent("\n".join(lines)).splitlines():
        if line.startswith(" ") and found:
            found[-1].append(line.strip())
        elif line.strip():
            found.append([line.strip()])
    return [" ".join(entry) for entry in found]


def definitions(lines):
    """A list of definitions; an entry without a colon is a term alone."""
    out = []
    for entry in entries(lines):
        name, colon, text = _split(entry)
        if not colon and out:  # a further line of the entry before
            out[-1:] = [out[-1] + " " + inline(entry), ""] if out[-1] else [f"   {inline(entry)}", ""]
            continue
        terms = ", ".join(f"``{term.strip()}``" for term in name.split(", ")) if colon else f"``{entry}``"
        out += [terms, f"   {inline(text)}" if text else "   \\", ""]
    return out


def _split(entry):
    """The name of an entry, a colon or an arrow, and its text."""
    match = re.match(r"^(\"?\*{0,2}[\w\"., ()*]+?\"?)(:| →) (.*)$", entry)
    return (match[1], match[2], match[3] if match[2] == ":" else f"→ {match[3]}") if match else (entry, "", "")


def raises(lines):
    """Classes of errors, each a link, and their codes."""
    text = " ".join(line.strip() for line in lines if line.strip())
    out = []
    for part in ERROR.split(text):
        match = re.match(r"(\w+)[:,.]?\s*(.*)", part.strip())
        if not match:
            continue
        name, rest = match[1], match[2].rstrip()
        shown = f":py:exc:`{name} <kinestatics.{name}>`" if name in ks.__all__ else f"``{name}``"
        out += [shown, f"   {inline(rest)}" if rest else "   \\", ""]
    return out


def convert(lines):
    """A docstring, whose indentation has been taken off, as reStructuredText."""
    sections, current = [("", [])], None
    for line in lines:
        header = HEADER.match(line)
        if header:
            sections.append((header[1], []))
            current = header[1]
        elif current and line.strip() and not line.startswith(" "):
            sections.append(("", [line]))
            current = None
        else:
            sections[-1][1].append(line)
    out = []
    for title, body in sections:
        dedented = textwrap.dedent("\n".join(body)).splitlines()
        if not title:
            out += paragraphs(body)
        elif title.startswith("Example"):
            out += [
                "",
                ".. container:: example",
                "",
                *textwrap.indent("\n".join(paragraphs(dedented)), "   ").splitlines(),
                "",
            ]
        elif title in ("Raises", "Warns"):
            out += ["", f":{title}:", *textwrap.indent("\n".join(raises(dedented)), "   ").splitlines(), ""]
        elif title in ("Returns", "Yields"):
            out += ["", f":{title}:", *textwrap.indent("\n".join(paragraphs(dedented)), "   ").splitlines(), ""]
        else:
            inner = definitions(dedented)
            out += ["", f":{TITLES[title]}:", *textwrap.indent("\n".join(inner), "   ").splitlines(), ""]
    return out


def process(app, what, name, obj, options, lines):
    """Sphinx's event: the lines are changed in place."""
    del app, what, name, obj, options
    lines[:] = convert(lines)


def setup(app):
    """Connects the conversion."""
    app.connect("autodoc-process-docstring", process)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
