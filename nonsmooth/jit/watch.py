"""Whether what compiled code was made from is still the same, in the time of a few dictionary look-ups.

What was looked up is compared by ``is``: immutable values cannot change, and whoever changes a global or the constant
of a module puts another object there. Arrays are compared by their content, those that the code reads in place by their
address. A False means "look closer": another object may have the same value.
"""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any

import numpy as np

MISSING: Any = object()  # stands for a name that is not there


class Watch:
    """What was looked up, and what was found there."""

    def __init__(self) -> None:
        self._names: dict[tuple[int, str], tuple[dict, str, Any]] = {}
        self._modules: dict[int, tuple[types.ModuleType, type]] = {}
        self._functions: list[tuple[Callable, Any, Any, Any]] = []
        self._cells: list[tuple[types.CellType, Any]] = []
        self._arrays: list[tuple[np.ndarray, tuple, bytes | None]] = []

    def name(self, scope: dict, name: str, value: Any) -> None:
        """A name among the globals of a function or the attributes of a module."""
        self._names[id(scope), name] = scope, name, value

    def module(self, module: types.ModuleType) -> None:
        """The class of a module, which may make what is read from it."""
        self._modules[id(module)] = module, type(module)

    def function(self, function: Callable) -> None:
        """The code and the defaults of a function."""
        self._functions.append((function, function.__code__, function.__defaults__, function.__kwdefaults__))
        defaults = function.__kwdefaults__ or {}
        for name, default in defaults.items():
            self.name(defaults, name, default)

    def cell(self, cell: types.CellType) -> Any:
        """A variable of an enclosing function; its value is returned."""
        value = content_of(cell)
        self._cells.append((cell, value))
        return value

    def array(self, array: np.ndarray, content: bytes | None) -> None:
        """An array, with its content where that is part of the code."""
        self._arrays.append((array, _place(array), content))

    def holds(self) -> bool:
        """Whether nothing has changed."""
        for scope, name, value in self._names.values():
            if scope.get(name, MISSING) is not value:
                return False
        if any(type(module) is not cls for module, cls in self._modules.values()):
            return False
        for function, code, defaults, by_name in self._functions:
            if (
                function.__code__ is not code
                or function.__defaults__ is not defaults
                or function.__kwdefaults__ is not by_name
            ):
                return False
        for cell, value in self._cells:
            if content_of(cell) is not value:
                return False
        for array, place, content in self._arrays:
            if _place(array) != place or (content is not None and array.tobytes(order="A") != content):
                return False
        return True


CHANGED = Watch()  # on something that is not what it was
CHANGED.name({}, "", None)


def content_of(cell: types.CellType) -> Any:
    """The value of a closed-over variable."""
    try:
        return cell.cell_contents
    except ValueError:  # not assigned yet
        return MISSING


def _place(array: np.ndarray) -> tuple:
    """Address, shape, strides and type of an array: each can be changed in place."""
    return array.ctypes.data, array.shape, array.strides, array.dtype, array.flags.writeable
