"""Object code, linked by LLVM and called by its address: a later process runs what is on the disk without numba.

Numba's import takes 0.28 s, and 6 ms an entry point what it makes of its own files: types, a wrapper for Python, the
intermediate code. Linked alone each takes 0.6 ms. Called from Python by `ctypes` a function takes 1 us, by numba's
wrapper 0.2 us. All functions that numba compiles have one form:

    int32 f(result *, raised **, arguments ...)         0 where nothing was raised
"""

from __future__ import annotations

import ctypes
import functools
import re
from collections.abc import Callable, Iterable
from itertools import chain
from typing import Any

import numpy as np

from nonsmooth.jit.object_code import ObjectCode, object_code

TYPES: dict[str, Any] = {"int64": ctypes.c_int64, "float64": ctypes.c_double, "boolean": ctypes.c_bool}
NUMBERS = r"\w+(?:, \w+)*"
KINDS = re.compile(r"\w+(?:\[(?::, )*::1\])?")  # of arguments: numbers, and arrays of float64 without gaps
SIGNATURE = re.compile(rf"(?:(?P<one>\w+)|Tuple\(\((?P<several>{NUMBERS})\)\))\((?P<given>[^()]+)\)")
MODEL = ctypes.PYFUNCTYPE(ctypes.c_int32, *2 * [ctypes.c_void_p], ctypes.c_int64, ctypes.c_double,
                         *4 * [ctypes.c_void_p])  # fmt: skip


class Linked:
    """Object code in memory, as long as this object lives.

    Attributes
    ----------
    address : int
        Where its function begins.
    """

    def __init__(self, part: ObjectCode) -> None:
        import llvmlite.binding as llvm

        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        machine = llvm.Target.from_triple(llvm.get_process_triple()).create_target_machine()
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
        require_known(part.needed)  # an engine makes known what the process has
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(part.code))
        self._engine.finalize_object()
        self.address = int(self._engine.get_function_address(part.symbol))


def require_known(symbols: Iterable[str]) -> None:
    """Numba is imported where the linker finds something with its help alone; LLVM ends the process where something is
    missing.

    Raises
    ------
    LookupError
        Where something is not found at all.
    """
    import llvmlite.binding as llvm

    missing = [symbol for symbol in symbols if not llvm.address_of_symbol(symbol)]
    if missing:
        from nonsmooth.jit.internals import cpu_target

        assert cpu_target.target_context is not None  # made as it is asked for
        missing = [symbol for symbol in missing if not llvm.address_of_symbol(symbol)]
    if missing:
        raise LookupError(f"the linker does not know {missing[0]}")


def linked(payload: bytes) -> Linked | None:
    """Link what is kept in a file; None where it is something else."""
    part = object_code(payload)
    return None if part is None else Linked(part)


# Calls from Python.


def function_at(address: int, signature: str) -> Callable[..., Any]:
    """What Python calls for machine code of numba's form; other threads run meanwhile.

    Raises
    ------
    TypeError
        Where the signature has something else than numbers, arrays of float64, and numbers returned.
    """
    found = SIGNATURE.fullmatch(signature)
    kinds = KINDS.findall(found["given"]) if found else []
    results = (found["several"] or found["one"]).split(", ") if found else []
    is_whole = found is not None and ", ".join(kinds) == found["given"]
    if not is_whole or not all(map(is_known, kinds)) or not (results == ["void"] or set(results) <= set(TYPES)):
        raise TypeError(f"Python calls no entry point {signature} by its address: mark it with takes_arrays=True")
    several = found is not None and found["several"]
    axes = [0 if name in TYPES else 1 + name.count(",") for name in kinds]
    types = chain.from_iterable(array_types(n) if n else (TYPES[name],) for name, n in zip(kinds, axes, strict=True))
    call = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *types)(address)
    Room = several_of(results) if several else TYPES.get(results[0], ctypes.c_void_p)
    raised, byref = ctypes.c_void_p(), ctypes.byref  # of all threads: what kernels raise is made as they are compiled
    to_raised = byref(raised)

    def function(*given: Any) -> Any:
        room = Room()
        if call(byref(room), to_raised, *given):
            from nonsmooth.jit.internals import exception_at

            raise exception_at(raised.value)
        return room.values() if several else room.value

    def with_arrays(*given: Any) -> Any:
        return function(*chain.from_iterable(map(parts_of, given, axes)))

    return with_arrays if any(axes) else function


def is_known(kind: str) -> bool:
    """Whether Python can hand over arguments of a kind."""
    return kind in TYPES or kind.startswith("float64[")


def array_types(axes: int) -> list[Any]:
    """Owner and its parent, numbers, bytes each, place, lengths, strides."""
    return [*2 * [ctypes.c_void_p], *2 * [ctypes.c_int64], ctypes.c_void_p, *2 * axes * [ctypes.c_int64]]


def several_of(names: list[str]) -> Any:
    """Room for some numbers that are returned."""

    class Several(ctypes.Structure):
        """As numba returns a tuple."""

        _fields_ = [(f"_{k}", TYPES[name]) for k, name in enumerate(names)]  # noqa: RUF012

        def values(self) -> tuple[Any, ...]:
            """The numbers."""
            return tuple([getattr(self, name) for name, *_ in self._fields_])

    return Several


def parts_of(value: Any, axes: int) -> tuple[Any, ...]:
    """A number; or what numba makes of an array: no owner, numbers, bytes each, their place, lengths and strides.

    Raises
    ------
    TypeError
        Where it is none of float64 without gaps, with so many axes.
    """
    if axes == 0:
        return (value,)
    if value.dtype != np.float64 or value.ndim != axes or not value.flags.c_contiguous:
        wanted = f"an array of float64 without gaps and with {axes} axes"
        raise TypeError(f"compiled code takes {wanted}, not {value.dtype} {value.shape}")
    return None, None, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides


@functools.cache
def doubles(n: int) -> type[ctypes.Array]:
    """The type of n numbers as compiled code takes them: of some few faster than an array, whose place takes 1 us to be
    found; so does this type."""
    return ctypes.c_double * n


def model_at(address: int) -> Callable[..., bool]:
    """What Python calls for machine code of a model, ``model(which, t, q, u, p, out)``, with the places of numbers, or
    arrays of `ctypes`; whether it raised nothing."""
    call, nothing = MODEL(address), ctypes.byref(ctypes.c_void_p())

    def function(which: int, t: float, q: Any, u: Any, p: Any, out: Any) -> bool:
        return call(nothing, nothing, which, t, q, u, p, out) == 0  # type: ignore[no-any-return]

    return function
