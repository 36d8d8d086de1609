"""The shell: one small module per command, parse → call → render. Floor 13.

Exit codes: 0 done, 1 `check` found faults or `doctor` something broken, 2 bad input.

Command modules import the package inside their functions, so that `--help` and `--version` need not load it.
"""

from __future__ import annotations

from .app import main

__all__ = ["main"]
