"""Python as a page shows it: run statement by statement, each output where it was printed.

As a program it runs one example and writes its cells as JSON: python cells.py EXAMPLE FOLDER_FOR_PICTURES OUT.json
"""

import ast
import contextlib
import io
import json
import linecache
import re
import sys
from pathlib import Path


def last_value(code, namespace, name="page"):
    """Runs some lines in a namespace; the value of the last, if it is an expression."""
    tree = ast.parse(code, name)
    linecache.cache[name] = (len(code), None, code.splitlines(keepends=True), name)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, name, "exec"), namespace)
    return eval(compile(ast.Expression(last.value), name, "eval"), namespace) if last else None


def prose(text):
    """Text of a docstring as Markdown: nothing in it is markup but `code`."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(part if part.startswith("`") else re.sub(r"([\\*_<>\[\]$|])", r"\\\1", part) for part in parts)


def fence(language, text):
    """A block of code, as Markdown."""
    return f"```{language}\n{text.rstrip()}\n```"


def paragraphs(source):
    """The code after the docstring: (text, statements) for each run of top-level statements without a blank line between."""
    lines, found = source.splitlines(), []
    body = ast.parse(source).body[1:]
    previous = body[0].lineno
    for node in body:
        begin = min([node.lineno, *(decorator.lineno for decorator in getattr(node, "decorator_list", []))])
        while begin > 1 and lines[begin - 2].startswith("#"):
            begin -= 1
        if not found or any(not line.strip() for line in lines[previous : begin - 1]):
            found.append((begin, []))
        found[-1][1].append(node)
        previous = node.end_lineno
    ends = [begin - 1 for begin, _ in found[1:]] + [len(lines)]
    return [("\n".join(lines[begin - 1 : end]).rstrip(), nodes) for (begin, nodes), end in zip(found, ends, strict=True)]


def run(path):
    """Runs an example; its cells, each the code up to something printed and what was printed."""
    source = Path(path).read_text(encoding="utf-8")
    namespace = {"__name__": "__main__", "__file__": str(path)}
    cells, pending = [], []
    for text, nodes in paragraphs(source):
        pending.append(text)
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(ast.Module(nodes, []), str(path), "exec"), namespace)
        if printed.getvalue():
            cells.append(("\n\n".join(pending), printed.getvalue()))
            pending = []
    if pending:
        cells.append(("\n\n".join(pending), ""))
    return cells


if __name__ == "__main__":
    example, pictures, out = sys.argv[1:]
    sys.argv = [example, pictures]
    Path(out).write_text(json.dumps(run(example)), encoding="utf-8")
