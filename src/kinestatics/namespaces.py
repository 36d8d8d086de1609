"""Which array library an argument speaks: NumPy, JAX, PyTorch, or NumPy arrays of SymPy expressions. Floor 1.

The definition asks a `Namespace` for the few functions that are not operators or methods. It is decided from the
argument alone; there is no global switch. None of the optional libraries is imported here before an array of theirs
has arrived.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np

from .errors import ArrayTypeError

Array = Any
"""An array of any supported library; shapes are given in docstrings."""


@dataclass(frozen=True)
class Namespace:
    """The functions the definition needs from an array library.

    Attributes:
        name: "numpy", "jax", "torch" or "sympy".
        sin, cos: elementwise.
        stack, concat: as in the array API, taking (arrays, axis).
        broadcast: (array, shape) → the array repeated to that shape.
        constant: turns a NumPy array into an array of this library, with the type and device of a given one.
        linalg: its linear algebra under the names of the array API (svdvals, solve, ...); None for SymPy.
    """

    name: str
    sin: Callable[[Array], Array]
    cos: Callable[[Array], Array]
    stack: Callable[[Sequence[Array], int], Array]
    concat: Callable[[Sequence[Array], int], Array]
    broadcast: Callable[[Array, tuple[int, ...]], Array]
    constant: Callable[[Array, Array], Array]
    linalg: Any

    def __reduce__(self) -> tuple[Any, ...]:
        return _namespace, (self.name,)  # its functions are those of a module: found again by name


def _numpy_constant(value: Array, like: Array) -> Array:
    return value if value.dtype == object else value.astype(like.dtype, copy=False)


_NUMPY = Namespace("numpy", np.sin, np.cos, np.stack, np.concatenate, np.broadcast_to, _numpy_constant, np.linalg)


@cache
def _sympy_namespace() -> Namespace:
    import sympy

    def elementwise(function: Callable[[Any], Any]) -> Callable[[Array], Array]:
        vectorized = np.vectorize(function, otypes=[object])
        return lambda x: vectorized(x) if x.size else x

    def exact(value: Any) -> Any:  # whole numbers become integers, so that no expression carries a factor 1.0
        return sympy.Integer(int(value)) if isinstance(value, float) and value.is_integer() else sympy.sympify(value)

    def constant(value: Array, like: Array) -> Array:
        del like
        return elementwise(exact)(value.astype(object))

    sin, cos = elementwise(sympy.sin), elementwise(sympy.cos)
    return Namespace("sympy", sin, cos, np.stack, np.concatenate, np.broadcast_to, constant, None)


def _jax_namespace() -> Namespace:
    jnp: ModuleType = sys.modules["jax.numpy"]

    def constant(value: Array, like: Array) -> Array:
        return jnp.asarray(value, dtype=like.dtype)

    return Namespace("jax", jnp.sin, jnp.cos, jnp.stack, jnp.concatenate, jnp.broadcast_to, constant, jnp.linalg)


def _torch_namespace() -> Namespace:
    torch: ModuleType = sys.modules["torch"]

    def constant(value: Array, like: Array) -> Array:
        return torch.tensor(np.ascontiguousarray(value), dtype=like.dtype, device=like.device)

    functions = (torch.sin, torch.cos, torch.stack, torch.concatenate, torch.broadcast_to)
    return Namespace("torch", *functions, constant, torch.linalg)


def _namespace(name: str) -> Namespace:
    """The namespace of that name, its library imported."""
    if name == "numpy":
        return _NUMPY
    if name == "sympy":
        return _sympy_namespace()
    import_module("jax.numpy" if name == "jax" else "torch")
    return _jax_namespace() if name == "jax" else _torch_namespace()


def _is_symbolic(array: Array) -> bool:
    expression = getattr(sys.modules.get("sympy"), "Expr", None)  # another thread may be half way through importing it
    return expression is not None and all(isinstance(x, expression | int | float) for x in array.flat)


def _floating_jax(value: Any, what: str) -> Array:
    """A JAX array of real numbers; whole numbers become floats of the size that JAX is set to."""
    jnp = sys.modules["jax.numpy"]
    if jnp.issubdtype(value.dtype, jnp.floating):
        return value
    if jnp.issubdtype(value.dtype, jnp.integer) or value.dtype == bool:
        return value.astype(float)
    raise ArrayTypeError("KS302", f"{what} has type {value.dtype}", "pass real numbers")


def as_array(value: Any, what: str = "q") -> tuple[Array, Namespace]:
    """`value` as a floating array of its own library, and the namespace of that library.

    Lists, integers and booleans become float64 (of JAX its default float); float32 and float64 stay; SymPy expressions
    become an object array.

    Args:
        value: array or nested list.
        what: how to call it in an error.

    Raises:
        ArrayTypeError: KS302 for complex, masked, text and other arrays that are no numbers.

    Example:
        >>> as_array([1, 2])[0].dtype.name
        'float64'
    """
    kind = type(value).__module__.partition(".")[0]
    if kind in ("jax", "jaxlib"):
        return _floating_jax(value, what), _jax_namespace()
    if kind == "torch":
        if value.is_complex():
            raise ArrayTypeError("KS302", f"{what} is a complex tensor", "pass real numbers")
        return (value if value.is_floating_point() else value.double()), _torch_namespace()
    if isinstance(value, np.ma.MaskedArray):
        raise ArrayTypeError("KS302", f"{what} is a masked array", "fill it first: array.filled(...)")
    array = np.asarray(value)
    if array.dtype == object:
        if array.ndim == 0 and not _is_symbolic(array):
            found = "None" if value is None else f"a {type(value).__name__}"
            raise ArrayTypeError("KS302", f"{what} is {found}", "pass numbers")
        if not _is_symbolic(array):
            raise ArrayTypeError(
                "KS302", f"{what} holds objects that are neither numbers nor SymPy expressions", "pass numbers or symbols"
            )
        return array, _sympy_namespace()
    if array.dtype.kind in "biu" or array.dtype == np.float16:
        return array.astype(np.float64), _NUMPY
    if array.dtype in (np.float32, np.float64):
        return np.asarray(array), _NUMPY
    if array.dtype.kind == "f":
        return array.astype(np.float64), _NUMPY
    raise ArrayTypeError("KS302", f"{what} has type {array.dtype}", "pass real numbers: float64, float32 or integers")
