"""Manipulability: measures, ellipsoids and polytopes; functions of a Jacobian and limits only. Floor 8."""

from .measures import condition_number, manipulability, singular_values

__all__ = ["condition_number", "manipulability", "singular_values"]
