"""Exact models and closed forms: everything that says SymPy or FLINT. Floor 7."""
