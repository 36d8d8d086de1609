"""The malformed robot files of golden/malformed.json, {file name: text}, each wrong in one way.

A long text is a list of [piece, times]; {i} and {next} in a piece count its repetitions.
"""

import json
from pathlib import Path

FOLDER = Path(__file__).parent / "golden"


def grown(pieces):
    return "".join(
        piece.replace("{i}", str(i)).replace("{next}", str(i + 1)) for piece, times in pieces for i in range(times)
    )


def malformed():
    stored = json.loads((FOLDER / "malformed.json").read_text(encoding="utf-8"))
    return {name: text if isinstance(text, str) else grown(text) for name, text in stored.items()}


def codes():
    return json.loads((FOLDER / "malformed_codes.json").read_text(encoding="utf-8"))["codes"]
