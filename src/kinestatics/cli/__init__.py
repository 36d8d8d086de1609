"""The shell: one small module per command, parse → call → render. Floor 11. Exit codes: 0 done, 2 bad input."""

from __future__ import annotations

from .app import main

__all__ = ["main"]
