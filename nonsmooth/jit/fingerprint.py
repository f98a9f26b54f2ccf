"""What compiled code depends on: the code of a function, its constants, and the globals that it reads, however deep.

numba itself would miss an edit of an inlined kernel in another file, and a changed constant; and it would compile anew
after an edit of a docstring.
"""

from __future__ import annotations

import enum
import functools
import hashlib
import types
import typing
from collections.abc import Callable, Iterator
from typing import Any


def identity(function: Callable) -> bytes:
    """The code of a function, its constants, defaults, closure and the globals it reads, as bytes."""
    code = function.__code__
    parts: list[Any] = [code.co_code, code.co_names, function.__defaults__]
    parts += [repr(c) for c in code.co_consts if c != function.__doc__ and not isinstance(c, types.CodeType)]
    parts += [repr(cell.cell_contents) for cell in function.__closure__ or ()]
    identity = repr(parts).encode()
    for name in sorted(set(names_of(code))):
        identity += _global_identity(function.__globals__.get(name), function)
    return identity


def _global_identity(value: Any, reader: Callable) -> bytes:
    """What a function depends on through one global that it reads."""
    if hasattr(value, "call_identity"):  # a kernel
        return bytes(value.call_identity())
    if isinstance(value, types.FunctionType):
        return b"" if value is reader else identity(value)
    if hasattr(value, "py_func"):  # a helper the user compiled himself
        return identity(value.py_func)
    if hasattr(value, "tobytes"):
        return bytes(value.tobytes())
    if isinstance(value, type):
        return _type_identity(value)
    return b"" if value is None or isinstance(value, types.ModuleType) else repr(value).encode()


@functools.cache
def digest(function: Callable) -> bytes:
    """A hash of ``identity``."""
    return hashlib.sha256(identity(function)).digest()


def _type_identity(cls: type) -> bytes:
    """The members of an enumeration, or the fields of a NamedTuple, however deep."""
    if issubclass(cls, enum.Enum):
        return repr(list(cls)).encode()
    hints = typing.get_type_hints(cls, include_extras=True) if hasattr(cls, "_fields") else {}
    return b"".join(
        name.encode() + (_type_identity(hint) if isinstance(hint, type) else repr(hint).encode())
        for name, hint in hints.items()
    )


def names_of(code: types.CodeType) -> Iterator[str]:
    """The globals and attributes that code reads, with the functions in it."""
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from names_of(constant)
