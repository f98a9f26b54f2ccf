"""What a Python function takes, returns and reads, by its signature and its code: nothing is called."""

from __future__ import annotations

import dis
import functools
import inspect
import types
from collections.abc import Callable, Iterator
from typing import Any

from nonsmooth.errors import InvalidInput, shown


def takes(function: Callable, arguments: tuple[str, ...]) -> bool:
    """Whether a function can be called with these arguments; True when in doubt."""
    if type(function) is types.FunctionType and not vars(function):  # a tenth of the time
        return _takes(function, len(arguments))
    try:
        inspect.signature(function).bind(*arguments)
    except TypeError:
        return False
    except Exception:  # without a signature, or an object that raises when it is asked
        return True
    return True


def _takes(function: types.FunctionType, n: int) -> bool:
    """The same of n arguments of a plain function, by its code."""
    code = function.__code__
    needed = code.co_argcount - len(function.__defaults__ or ())
    is_named = code.co_kwonlyargcount > len(function.__kwdefaults__ or ())  # one more has to be given by its name
    return not is_named and needed <= n and (n <= code.co_argcount or bool(code.co_flags & inspect.CO_VARARGS))


def returns_values(function: Callable) -> bool:
    """Whether a function with a return has something to return besides None; True when in doubt."""
    function = getattr(function, "py_func", function)
    code = getattr(function, "__code__", None)
    return code is None or any(_returned(code))


def _returned(code: types.CodeType) -> Iterator[bool]:
    """Of each return of a code, whether it returns something."""
    is_nothing = False
    for instruction in dis.get_instructions(code):
        if instruction.opname in ("RETURN_VALUE", "RETURN_CONST"):
            yield not (instruction.argval is None if instruction.opname == "RETURN_CONST" else is_nothing)
        is_nothing = instruction.opname == "LOAD_CONST" and instruction.argval is None


@functools.cache
def reads_argument(code: types.CodeType | None, position: int) -> bool:
    """Whether code reads its argument at a position; True when in doubt."""
    if code is None:
        return True
    name = code.co_varnames[position]
    return name in code.co_cellvars or any(
        instruction.opname.startswith("LOAD_FAST") and name in str(instruction.argrepr).replace(",", " ").split()
        for instruction in dis.get_instructions(code)
    )


def is_hashable(value: Any) -> bool:
    """Whether a function, or what stands for one, can be a key."""
    try:
        hash(value)
    except Exception:  # a list, or an object that raises
        return False
    return True


def require_arguments(name: str, function: Callable[..., Any], expected: tuple[str, ...]) -> None:
    """Refuse a function that cannot be called with so many arguments."""
    if is_hashable(function):
        _require_arguments(name, function, expected)
    else:
        _require_arguments.__wrapped__(name, function, expected)


@functools.lru_cache(maxsize=512)
def _require_arguments(name: str, function: Callable[..., Any], expected: tuple[str, ...]) -> None:
    try:
        signature = inspect.signature(function)
    except ValueError:  # a callable without a signature
        return
    except Exception:  # whatever an object raises that is asked what it takes
        raise InvalidInput(f"{name} must be a function; got {shown(function)}") from None
    try:
        signature.bind(*expected)
    except TypeError:
        returns = ", which returns nothing in its place" if len(signature.parameters) == len(expected) - 1 else ""
        raise InvalidInput(f"{name} must take ({', '.join(expected)}); got {name}{signature}{returns}") from None
