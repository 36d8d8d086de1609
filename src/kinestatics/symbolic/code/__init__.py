"""Closed forms as functions in other languages. Floor 7."""

from .arithmetic import evaluated
from .generate import generate_code
from .languages import LANGUAGES
from .self_check import by_definition, drawn

__all__ = ["LANGUAGES", "by_definition", "drawn", "evaluated", "generate_code"]
