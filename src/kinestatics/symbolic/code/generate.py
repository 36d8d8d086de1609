"""`generate_code`: closed forms as functions in NumPy, JAX, C, C++, MATLAB and Octave. Floor 7.

Sines and cosines of every sum of angles are computed once, and so is whatever else occurs twice. Names come from the
model's symbols and are made identifiers of the language; text from models enters comments only, stripped of all marks.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...errors import UnknownNameError, nearest
from ...quantities import Jacobian
from ..closed_form import ClosedForm
from ..exact import sympy_module
from .identifiers import Names, function_name
from .languages import LANGUAGE_OF, LANGUAGES
from .programs import program_of
from .self_check import check_steps
from .sources import WRITERS
from .steps import steps_of


def generate_code(
    x: Any,
    language: str = "numpy",
    name: str | None = None,
    check: bool = True,
    *,
    arguments: Mapping[str, Any] | None = None,
) -> str:
    """An expression as a function in another language.

    Args:
        x: ClosedForm, SymPy expression or matrix, array of expressions, or a quantity at symbols such as a Jacobian.
        language: "numpy", "jax", "c", "cpp", "matlab" or "octave".
        name: of the function; default the quantity's, else "evaluate".
        check: whether the steps are compared, at random numbers, with the expression and, for a ClosedForm, with the numeric
            definition.
        arguments: argument → symbol, or list of symbols that come as one array, in order. Default: for closed forms q, qd,
            qdd, wrench and then every parameter; for other expressions every symbol, by name.

    Returns:
        The source. In NumPy and JAX a function of arrays with batch axes first that returns (..., rows, columns); in C a
        function that fills an array row by row; in C++ one that returns it as std::array; in MATLAB and Octave a matrix. Its
        header says shapes, units, rows, frame, and which names were changed because the language takes them.

    Raises:
        UnknownNameError: KS395, no such language. ConfigurationError: KS395, a name that is no identifier, arguments that
            leave a symbol out. ArrayTypeError: KS395, no code for a function; KS302, nothing to write.
        KinestaticsError: KS396, the check failed. MissingExtraError: KS400.

    Law: the function at numbers is the expression at these numbers, to rounding.

    Example:
        >>> import kinestatics as ks
        >>> form = ks.closed_form("determinant", ks.load("planar_2r"), lengths="symbols")
        >>> print(ks.generate_code(form, "c").partition("#include")[2])
         <math.h>
        <BLANKLINE>
        double determinant(const double *q, double a1)
        {
            const double s2 = sin(q[1]);
            return s2*(a1*a1);
        }
        <BLANKLINE>
    """
    sympy_module()
    if not isinstance(language, str) or language.lower() not in LANGUAGE_OF:
        raise UnknownNameError(
            "KS395", f"no code in {language!r}", nearest(str(language), LANGUAGES) or ", ".join(LANGUAGES)
        )
    spoken = LANGUAGE_OF[language.lower()]
    function = function_name(name if name is not None else _wished_name(x), spoken)
    program = program_of(x, arguments)
    names = Names(spoken, function)
    steps = steps_of(program, names)
    if check:
        check_steps(program, steps)
    return WRITERS[language.lower()](program, steps, names, spoken)


def _wished_name(x: Any) -> str:
    if isinstance(x, ClosedForm):
        return x.quantity
    return "jacobian" if isinstance(x, Jacobian) else "evaluate"
