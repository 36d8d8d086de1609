"""`analyze`: what can this arm do, here? One frozen result with every number a surface may show. Floor 9."""

from .compute import analyze
from .result import Analysis, Margin

__all__ = ["Analysis", "Margin", "analyze"]
