"""A user's friction law as a machine address, and the call through it: mu = law(v, p).

The law is compiled as a model of one function (models.py), which finds v in the place of the time:

    model(0, v, q*, u*, p*, out*),    out[0] = mu

``call_law(handle, p, v)`` calls it from a kernel; handle and p are the addresses of its code and of the parameters,
which stand in the row of laws of a contact (an integer below 2^53 is a float64). In the interpreter the handle finds
the Python function in `LAWS`. A law that raises gives NaN.
"""

from __future__ import annotations

import ctypes
import functools
import math
from collections.abc import Callable
from typing import Any, NamedTuple

from nonsmooth.jit.kernels import Kernel
from nonsmooth.jit.parameters import Unpack


class KnownLaw(NamedTuple):
    """What a handle stands for: the law of two arguments, what makes p, and what keeps machine code alive."""

    function: Callable
    unpack: Unpack
    keep: Any


CALL = b"model(0, v, q, u, p, out)"  # code: of how a law is called, for the keys of what calls it
LAWS: dict[int, KnownLaw] = {}  # by their handles


def numbers_at(address: int, unpack: Unpack) -> Any:
    """The parameters of a law, unpacked, from where they stand."""
    return unpack(*(ctypes.c_double * unpack.size).from_address(address))


def _call_law_interpreted(handle: int, p: int, v: float) -> float:
    law = LAWS[handle]
    try:
        return float(law.function(v, numbers_at(p, law.unpack)))
    except (ArithmeticError, ValueError):
        return math.nan


class _CallLaw(Kernel):
    """``call_law(handle, p, v) -> mu``."""

    continuation: Callable  # for complex numbers (mechanics/own_law.py)

    def call_identity(self) -> bytes:
        """What a kernel that calls laws depends on: how, and not which ones are known."""
        return CALL

    @functools.cached_property
    def inlined(self) -> Any:
        """What kernels call: a call of the address; NaN where there is none, or the law raised."""
        from numba import types as nb
        from numba.extending import intrinsic

        from nonsmooth.jit.internals import cgutils

        pointer = nb.CPointer(nb.float64)
        argument_types = [nb.int64, nb.float64, pointer, pointer, pointer, pointer]

        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            """The machine code: one number on the stack for the answer."""
            handle, p, v = args
            kind = context.get_value_type(nb.float64)
            out = cgutils.alloca_once_value(builder, context.get_constant(nb.float64, math.nan))
            with builder.if_then(builder.icmp_signed(">", handle, context.get_constant(nb.int64, 0))):
                convention = context.call_conv
                function_type = convention.get_function_type(nb.none, argument_types)
                function = builder.inttoptr(handle, function_type.as_pointer())
                numbers = builder.inttoptr(p, kind.as_pointer())
                given = [context.get_constant(nb.int64, 0), v, out, out, numbers, out]
                status, _ = convention.call_function(builder, function, nb.none, argument_types, given)
                with builder.if_then(builder.not_(status.is_ok)):
                    builder.store(context.get_constant(nb.float64, math.nan), out)
            return builder.load(out)

        @intrinsic
        def call_law(typing_context, handle, p, v):  # type: ignore[no-untyped-def]
            """The typing of the call."""
            return nb.float64(nb.int64, nb.int64, nb.float64), generate

        return call_law


call_law = _CallLaw(_call_law_interpreted)
