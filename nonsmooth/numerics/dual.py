"""Dual numbers a + b h, h^2 = 0, carried by complex ones: a function of a + h has its derivative beside its value.

    f(a + b h) = f(a) + f'(a) b h

h is a number so small (1e-30) that h^2 is nothing beside any quantity: sums and products of complex numbers are those
of dual ones then. Functions and quotients are written out, so that the real part has the bits of the real function, and
what decides (``<``, ``min``, ``abs``) looks at the real part: the derivative is that of the branch that is taken. All
of it runs as it stands and compiles; no attribute has these names, since the compilation binds what a function reads by
name. Source: Squire and Trapp, *SIAM Review* 40 (1998) 110; Griewank and Walther, *Evaluating Derivatives* (2008),
chapter 3.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np


def dual_sin(z):
    return complex(math.sin(z.real), math.cos(z.real) * z.imag)


def dual_cos(z):
    return complex(math.cos(z.real), -math.sin(z.real) * z.imag)


def dual_tan(z):
    y = math.tan(z.real)
    return complex(y, (1.0 + y * y) * z.imag)


def dual_asin(z):
    return complex(math.asin(z.real), z.imag / math.sqrt((1.0 - z.real) * (1.0 + z.real)))


def dual_acos(z):
    return complex(math.acos(z.real), -z.imag / math.sqrt((1.0 - z.real) * (1.0 + z.real)))


def dual_atan(z):
    return complex(math.atan(z.real), z.imag / (1.0 + z.real * z.real))


def dual_atan2(y, x):
    a, b = y.real, x.real
    return complex(math.atan2(a, b), (b * y.imag - a * x.imag) / (a * a + b * b))


def dual_sinh(z):
    return complex(math.sinh(z.real), math.cosh(z.real) * z.imag)


def dual_cosh(z):
    return complex(math.cosh(z.real), math.sinh(z.real) * z.imag)


def dual_tanh(z):
    y = math.tanh(z.real)
    return complex(y, (1.0 - y) * (1.0 + y) * z.imag)


def dual_asinh(z):
    return complex(math.asinh(z.real), z.imag / math.sqrt(z.real * z.real + 1.0))


def dual_acosh(z):
    return complex(math.acosh(z.real), z.imag / math.sqrt((z.real - 1.0) * (z.real + 1.0)))


def dual_atanh(z):
    return complex(math.atanh(z.real), z.imag / ((1.0 - z.real) * (1.0 + z.real)))


def dual_exp(z):
    y = math.exp(z.real)
    return complex(y, y * z.imag)


def dual_expm1(z):
    return complex(math.expm1(z.real), math.exp(z.real) * z.imag)


def dual_log(z):
    return complex(math.log(z.real), z.imag / z.real)


def dual_log1p(z):
    return complex(math.log1p(z.real), z.imag / (1.0 + z.real))


def dual_log2(z):
    return complex(math.log2(z.real), z.imag / (z.real * math.log(2.0)))


def dual_log10(z):
    return complex(math.log10(z.real), z.imag / (z.real * math.log(10.0)))


def dual_sqrt(z):
    y = math.sqrt(z.real)
    return complex(y, 0.5 * z.imag / y if z.imag != 0.0 else 0.0)


def dual_hypot(x, y):
    r = math.hypot(x.real, y.real)
    slope = x.real * x.imag + y.real * y.imag
    return complex(r, slope / r if slope != 0.0 else 0.0)


def dual_power(z, y):
    """z^y; the exponent mostly has no part in h."""
    a, n = z.real, y.real
    slope = 0.0
    if z.imag != 0.0:
        slope += n * a ** (n - 1.0) * z.imag
    if y.imag != 0.0:
        slope += a**n * math.log(a) * y.imag
    return complex(a**n, slope)


def dual_quotient(x, y):
    b = y.real
    return complex(x.real / b, (x.imag - x.real / b * y.imag) / b)


def dual_absolute(z):
    return -z if z.real < 0.0 else z


def dual_copysign(x, y):
    return dual_absolute(x) if math.copysign(1.0, y.real) > 0.0 else -dual_absolute(x)


def dual_sign(z):
    return complex(1.0 if z.real > 0.0 else -1.0 if z.real < 0.0 else 0.0, 0.0)


def dual_least(x, y):
    return y if y.real < x.real else x


def dual_largest(x, y):
    return y if y.real > x.real else x


def dual_same(z):
    """What ``float(z)`` becomes."""
    return z


def dual_whole(z):
    """What ``int(z)`` becomes: a number that counts, without a part in h."""
    return int(z.real)


def dual_floor(z):
    return math.floor(z.real)


def dual_ceil(z):
    return math.ceil(z.real)


def dual_radians(z):
    return z * (math.pi / 180.0)


def dual_degrees(z):
    return z * (180.0 / math.pi)


def dual_real(z):
    """The real part, which decides; also of what is no number."""
    return z.real


# What stands in for the functions of math, of NumPy and of Python that know real numbers only, by their names there.
OF_MATH: dict[str, Callable] = {
    "sin": dual_sin, "cos": dual_cos, "tan": dual_tan, "asin": dual_asin, "acos": dual_acos, "atan": dual_atan,
    "sinh": dual_sinh, "cosh": dual_cosh, "tanh": dual_tanh, "asinh": dual_asinh, "acosh": dual_acosh,
    "atanh": dual_atanh, "atan2": dual_atan2, "exp": dual_exp, "expm1": dual_expm1, "log": dual_log,
    "log1p": dual_log1p, "log2": dual_log2, "log10": dual_log10, "sqrt": dual_sqrt, "hypot": dual_hypot,
    "pow": dual_power, "fabs": dual_absolute, "copysign": dual_copysign, "radians": dual_radians,
    "degrees": dual_degrees, "floor": dual_floor, "ceil": dual_ceil,
}  # fmt: skip
OF_NUMPY: dict[str, Callable] = {
    "arcsin": dual_asin, "arccos": dual_acos, "arctan": dual_atan, "arcsinh": dual_asinh, "arccosh": dual_acosh,
    "arctanh": dual_atanh, "arctan2": dual_atan2, "power": dual_power, "abs": dual_absolute, "sign": dual_sign,
    "minimum": dual_least, "maximum": dual_largest, "deg2rad": dual_radians, "rad2deg": dual_degrees,
}  # fmt: skip
ALIKE = OF_MATH.keys() - {"asin", "acos", "atan", "asinh", "acosh", "atanh", "atan2", "pow", "floor", "ceil"}
OF_PYTHON: dict[Any, Callable] = {
    abs: dual_absolute, min: dual_least, max: dual_largest, float: dual_same, pow: dual_power, int: dual_whole,
}  # fmt: skip
STANDS_IN: dict[Any, Callable] = {
    **OF_PYTHON,
    **{getattr(math, name): function for name, function in OF_MATH.items()},
    **{getattr(np, name): function for name, function in OF_NUMPY.items()},
    **{getattr(np, name): OF_MATH[name] for name in ALIKE},
}
TWO_OR_MORE = (dual_least, dual_largest)  # of which Python's min and max take more than two
