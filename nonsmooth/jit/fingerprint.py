"""What machine code was made from: the code of a function and the value of all that it reads, however deep.

The instructions of a function say which globals, closed-over variables and attributes of modules it reads (`bytecode`).
Each is looked up, and its value is part of the hash:

    numbers, texts, arrays       type, dtype, shape, layout and bytes
    tuples, NamedTuples, enums   their class and their entries
    functions                    what they read in turn; a function met again stands for its number, so cycles end
    what numba compiles          its Python source, options and signatures
    numpy, numba, math, ...      the name: their versions belong to every key

A module can be read from, not handed on: what is read from it there is not seen. What else is met has no identity:
`Unidentified` says what it is, and nothing is compiled. Results of an earlier run are identified by more (`content`).
"""

from __future__ import annotations

import builtins
import enum
import functools
import hashlib
import sys
import types
from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.jit.bytecode import SCALARS, Reading, constant, reading, scalar
from nonsmooth.jit.libraries import is_library, library_path, name_of
from nonsmooth.jit.watch import MISSING, Watch

# Bytes up to which numba copies an array into the code, if its entries follow each other; others it reads in place.
COPIED = 10**6


class Unidentified(Exception):
    """A function reads something whose value cannot be distinguished from another one; ``str`` says what."""


@functools.cache
def digest(function: Callable) -> bytes:
    """A hash of all that a function of this package is made from; its own constants never change within a process.

    Raises
    ------
    Unidentified
        Where it reads something without an identity.
    """
    survey = Survey()
    survey.function(function)
    return survey.digest()


class Survey:
    """A hash of functions and values, and a watch on what was looked up for it."""

    def __init__(self) -> None:
        self.watch = Watch()
        self.meets_compiled = False  # whether a function that the user compiled with numba is among them
        self._hash = hashlib.sha256()
        self._numbers: dict[int, int] = {}  # of the functions and classes met, by their address
        self._met: list[Any] = []  # kept alive, so that no address is used again

    def digest(self) -> bytes:
        """The hash of what was added so far."""
        return self._hash.digest()

    def put(self, *parts: bytes) -> None:
        """Add bytes, each with its length."""
        for part in parts:
            self._hash.update(len(part).to_bytes(8, "little") + part)

    def _is_new(self, value: Any) -> bool:
        """Whether a function or class is met for the first time; if not, its number is added."""
        is_new = id(value) not in self._numbers
        if is_new:
            self._numbers[id(value)] = len(self._met)
            self._met.append(value)
        self.put(b"new" if is_new else b"again", self._numbers[id(value)].to_bytes(4, "little"))
        return is_new

    def unidentified(self, value: Any, what: str) -> None:
        """Nothing stands for a value without an identity."""
        raise Unidentified(what)

    def is_library(self, module: types.ModuleType) -> bool:
        """Whether what a module has is known by its name."""
        return is_library(module)

    def library(self, path: str) -> None:
        """Add the name of something that a library has."""
        self.put(b"library", path.encode())

    def members(self, cls: type, what: str) -> None:
        """Add what a class of the user's has apart from its entries, which machine code does not call."""

    def copies(self, array: np.ndarray, layout: str) -> bool:
        """Whether numba copies an array into the code."""
        return layout != "A" and array.nbytes <= COPIED

    # functions

    def function(self, function: Callable) -> None:
        """Add a Python function."""
        if not self._is_new(function):
            return
        code = function.__code__
        found = reading(code)
        if found.refusal:
            self.unidentified(function, f"{function.__name__}, which {found.refusal}")
        for module in found.imports:
            self.imported(function, module)
        self.watch.function(function)
        self.put(b"function", found.code)
        self.value(function.__defaults__, f"a default of {function.__name__}")
        for name, default in sorted((function.__kwdefaults__ or {}).items()):
            self.put(name.encode())
            self.value(default, f"the default {name} of {function.__name__}")
        self._globals(function, found)
        self._closure(function, found)

    def imported(self, function: Any, module: str) -> None:
        """Nothing stands for a module that a function imports as it runs."""
        self.unidentified(function, f"{function.__name__}, which imports a module as it runs")

    def _globals(self, function: Callable, found: Reading) -> None:
        scope = function.__globals__
        for name, *attributes in found.names:
            value = scope.get(name, MISSING)
            self.watch.name(scope, name, value)
            if value is MISSING:
                value = vars(builtins).get(name, MISSING)
                self.watch.name(vars(builtins), name, value)
            self._path(value, name, attributes)

    def _closure(self, function: Callable, found: Reading) -> None:
        cells = dict(zip(function.__code__.co_freevars, function.__closure__ or (), strict=True))
        for name, *attributes in found.free:
            self._path(self.watch.cell(cells[name]), name, attributes)

    def _path(self, value: Any, name: str, attributes: list[str]) -> None:
        """Add what stands at the end of ``name.attribute.attribute``, as far as modules lead."""
        for attribute in attributes:
            if not isinstance(value, types.ModuleType):
                break
            module, name = value, f"{name}.{attribute}"
            self.watch.module(module)
            value = vars(module).get(attribute, MISSING)
            self.watch.name(vars(module), attribute, value)
            if self.is_library(module):
                value = getattr(module, attribute, MISSING)  # numpy loads some of its modules when they are read
                path = f"{module.__name__}.{attribute}"
                if self._is_of_library(value):
                    self.library(path)
                    self.put(name_of(value).encode())
                    return
                self.put(b"library", path.encode())
            elif type(module) is not types.ModuleType or (value is MISSING and hasattr(module, "__getattr__")):
                return self.unidentified(module, f"{name}, which its module may make when it is read")
        if value is MISSING:
            self.put(b"missing")
        else:
            self.value(value, name)

    # values

    def value(self, value: Any, name: str) -> None:
        """Add a value; its name is for messages."""
        kind = type(value)
        if kind in SCALARS:
            self.put(scalar(value))
        elif kind is tuple or (isinstance(value, tuple) and hasattr(kind, "_fields")):
            self._tuple(value, name)
        elif kind is np.ndarray and not value.dtype.hasobject:
            self._array(value)
        elif isinstance(value, np.generic) and not value.dtype.hasobject:
            self.put(b"numpy", repr(value.dtype).encode(), value.tobytes())
        elif isinstance(value, enum.Enum):
            self._class(kind, name)
            self.put(value.name.encode() if value.name else repr(value).encode())
        elif isinstance(value, type):
            self._class(value, name)
        elif hasattr(kind, "call_identity"):  # a kernel
            self.put(b"kernel", value.call_identity())
        elif path := library_path(value, self.is_library):
            self.library(path)
        elif isinstance(value, types.FunctionType):
            self.function(value)
        else:
            self._other(value, name)

    def _tuple(self, value: tuple, name: str) -> None:
        if type(value) is not tuple:
            self._class(type(value), name)
        self.put(b"tuple", len(value).to_bytes(8, "little"))
        labels = getattr(value, "_fields", None) or range(len(value))
        for label, entry in zip(labels, value, strict=True):
            self.value(entry, f"{name}.{label}" if isinstance(label, str) else f"{name}[{label}]")

    def _array(self, array: np.ndarray) -> None:
        """Its content where numba copies it, else its address: the code sees each change of the content."""
        layout = "C" if array.flags.c_contiguous else "F" if array.flags.f_contiguous else "A"
        facts = (repr(array.dtype), array.shape, layout, array.flags.writeable, array.flags.aligned)
        content = array.tobytes(order="A") if self.copies(array, layout) else None
        self.put(b"array", repr(facts).encode())
        self.put(content if content is not None else repr((array.strides, array.ctypes.data)).encode())
        self.watch.array(array, content)

    def _class(self, cls: type, name: str) -> None:
        """The members of an enumeration, the fields of a NamedTuple; exceptions and library classes by their names."""
        if not self._is_new(cls):
            return
        if issubclass(cls, enum.Enum):
            self.put(b"enum", cls.__qualname__.encode(), *(base.__name__.encode() for base in cls.__mro__))
            for label, member in cls.__members__.items():
                self.put(label.encode())
                self.value(member.value, f"{name}.{label}")
            self.members(cls, name)
        elif issubclass(cls, tuple) and hasattr(cls, "_fields"):
            self.put(b"NamedTuple", *map(str.encode, cls._fields))
            self.value(tuple(getattr(cls, "_field_defaults", {}).items()), f"a default of {name}")
            self.members(cls, name)
        elif hasattr(cls, "layout_identity"):  # a block
            self.put(b"block", cls.layout_identity())
        elif path := library_path(cls, self.is_library):
            self.library(path)
        elif issubclass(cls, BaseException):
            self.put(b"class", f"{cls.__module__}.{cls.__qualname__}".encode())
        else:
            self.unidentified(cls, f"{name}, the class {cls.__qualname__}")

    def _other(self, value: Any, name: str) -> None:
        """Types, slices and compiled functions; what else there is has no identity."""
        if isinstance(value, np.dtype) and not value.hasobject:
            self.put(b"dtype", repr(value).encode())
            return
        if type(value) is slice and all(type(part) in SCALARS for part in (value.start, value.stop, value.step)):
            self.put(constant(value))
            return
        source = _numba_source(value)
        if source is None:
            return self.unidentified(value, f"{name}, {_described(value)}")
        description, function = source
        self.put(description.encode())
        if function is not None:
            self.meets_compiled = True
            self.function(function)

    # what a library has under its name

    def _is_of_library(self, value: Any) -> bool:
        """Whether a function or class that a library was asked for is its own: anyone may put another there."""
        is_plain = type(value) in SCALARS or isinstance(value, np.ndarray | np.generic | tuple | list | dict)
        if is_plain or isinstance(value, types.ModuleType) or value is MISSING:
            return False
        home = getattr(value, "__module__", None)
        module = sys.modules.get(home) if isinstance(home, str) else None
        return self.is_library(module) if module is not None else not isinstance(value, types.FunctionType)


def _described(value: Any) -> str:
    return "a module that is handed on" if isinstance(value, types.ModuleType) else f"a {type(value).__name__}"


def _numba_source(value: Any) -> tuple[str, types.FunctionType | None] | None:
    """A description and the Python function of what numba compiles; None where nothing is known of it."""
    if "numba" not in sys.modules:
        return None
    from nonsmooth.jit.internals import source_of

    return source_of(value)


def python_function(value: Any) -> types.FunctionType | None:
    """The Python function of what the user compiled with numba; None for anything else."""
    source = _numba_source(value)
    return None if source is None else source[1]
