"""Where an arm is singular: all of it, in closed form where there is one, with names. Floor 8."""

from .search import singularities
from .singular_set import SingularSet

__all__ = ["SingularSet", "singularities"]
