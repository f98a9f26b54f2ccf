"""Derivatives of model functions, exact to rounding, by a step into the complex plane.

    df/dx = Im f(x + i h)/h + O(h^2),    h = 1e-30

Nothing is subtracted, so h can be so small that the truncation vanishes. The model's function is run as it was
written, with the functions of ``math`` and ``numpy`` that know real numbers only replaced by their continuations;
``abs``, ``<``, ``min`` and ``max`` look at the real part: the derivative is that of the branch that is taken. Source:
Squire and Trapp, *SIAM Review* 40 (1998) 110.
"""

from __future__ import annotations

import functools
import math
import types
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.errors import InvalidInput
from nonsmooth.jit import Kernel
from nonsmooth.jit.bytecode import reading
from nonsmooth.jit.content import Glance
from nonsmooth.jit.watch import Watch

# derived: h; h^2 lies below the rounding of any quantity, h itself far above the smallest number
COMPLEX_INCREMENT = 1e-30
# chosen: of a derivative; beyond it the function has a pole here, or leaves its domain (sqrt of -1 has Im = 1)
LARGEST_DERIVATIVE = 1e15


def jacobian(function: Callable[[np.ndarray], np.ndarray], x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """f(x) (m,) and df/dx (m, n) of a function that takes a complex vector.

    Raises
    ------
    InvalidInput
        When the function cannot be run with complex numbers, or is not smooth at x.
    """
    columns, value = [], np.zeros(0)
    with warnings.catch_warnings(), np.errstate(invalid="ignore", divide="ignore"):
        warnings.simplefilter("error", np.exceptions.ComplexWarning)  # an imaginary part that would be lost
        for j in range(x.size):
            z = x.astype(complex)
            z[j] += 1j * COMPLEX_INCREMENT
            try:
                f = np.asarray(function(z))
            except (TypeError, AttributeError, np.exceptions.ComplexWarning) as error:
                raise InvalidInput(f"the model's functions cannot be run with complex numbers: {error}") from None
            columns.append(f.imag / COMPLEX_INCREMENT)
            value = f.real
    derivative = np.stack(columns, axis=-1)
    if not (np.isfinite(value).all() and (np.abs(derivative) <= LARGEST_DERIVATIVE).all()):
        raise InvalidInput(f"the model's functions are not finite or not smooth at {np.array2string(x, precision=6)}")
    return value, derivative


def complexified(function: Any) -> Callable:
    """The function with every function it calls able to take complex numbers; made anew where what it reads changed."""
    if hasattr(function, "continuation"):  # a row derived from its gap
        return function.continuation
    if isinstance(function, Kernel):
        return complexified(function.function)
    if hasattr(function, "py_func"):  # compiled by numba
        return complexified(function.py_func)
    if not isinstance(function, types.FunctionType):
        return function
    kept = _kept(function)
    if not kept or not kept[0][1].holds():
        kept[:] = [(_copy(function), Glance(function).watch)]
    return kept[0][0]


@functools.lru_cache(maxsize=1024)
def _kept(function: Callable) -> list[tuple[Callable, Watch]]:
    """Where the copy of a function is kept, with the watch on what it was made from."""
    return []


def _copy(function: types.FunctionType) -> Callable:
    scope = dict(function.__globals__) | {"abs": _abs}
    closure = tuple(types.CellType(_continuation(cell.cell_contents)) for cell in function.__closure__ or ())
    copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__, closure or None)
    for name, *_ in reading(function.__code__).names:
        if name in scope and scope[name] is not function:
            scope[name] = _continuation(scope[name])
    return copy


def _continuation(value: Any) -> Any:
    """What stands in for a module or a function that a model function uses."""
    if value is math:
        return COMPLEX_MATH
    if value is np:
        return COMPLEX_NUMPY
    if isinstance(value, types.BuiltinFunctionType) and value.__module__ == "math":
        return getattr(COMPLEX_MATH, value.__name__)
    if isinstance(value, types.FunctionType | Kernel) or hasattr(value, "py_func"):
        return complexified(value)
    if isinstance(value, np.ufunc):
        return REAL_ONLY.get(value.__name__, value)
    return value


def _abs(x: Any) -> Any:
    return -x if np.real(x) < 0 else x


def _copysign(x: Any, y: Any) -> Any:
    return _abs(x) if math.copysign(1.0, np.real(y)) > 0 else -_abs(x)


def _sign(x: Any) -> Any:
    return np.sign(np.real(x))


def _atan2(y: Any, x: Any) -> Any:
    """arctan2 to first order in the imaginary parts: all that a step of 1e-30 can see."""
    a, b = np.real(y), np.real(x)
    return np.arctan2(a, b) + 1j * (b * np.imag(y) - a * np.imag(x)) / (a * a + b * b)


def _hypot(x: Any, y: Any) -> Any:
    return np.sqrt(x * x + y * y)


def _pow(x: Any, y: Any) -> Any:
    return np.complex128(x) ** y


COMPLEX_MATH = types.SimpleNamespace(
    pi=math.pi, e=math.e, tau=math.tau, inf=math.inf, nan=math.nan,
    sin=np.sin, cos=np.cos, tan=np.tan, asin=np.arcsin, acos=np.arccos, atan=np.arctan, atan2=_atan2,
    sinh=np.sinh, cosh=np.cosh, tanh=np.tanh, asinh=np.arcsinh, acosh=np.arccosh, atanh=np.arctanh,
    exp=np.exp, expm1=np.expm1, log=np.log, log1p=np.log1p, log10=np.log10, log2=np.log2, sqrt=np.sqrt,
    fabs=_abs, copysign=_copysign, hypot=_hypot, pow=_pow,
    radians=lambda x: x * math.pi / 180, degrees=lambda x: x * 180 / math.pi,
)  # fmt: skip
REAL_ONLY: dict[str, Callable] = {
    "abs": np.vectorize(_abs), "absolute": np.vectorize(_abs), "fabs": np.vectorize(_abs), "sign": _sign,
    "arctan2": _atan2, "hypot": _hypot, "copysign": np.vectorize(_copysign),
}  # fmt: skip
COMPLEX_NUMPY = types.SimpleNamespace(**(vars(np) | REAL_ONLY))
