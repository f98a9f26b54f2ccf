"""Copies of the functions that a model function calls, compiled afresh with it.

Plain Python functions become compiled ones. Those that the user compiled with numba are compiled again from their
source: numba keeps what it compiled first, whatever became of the values that it read. Where a function is read from a
module, the copy reads it from a copy of the module.
"""

from __future__ import annotations

import types
from collections.abc import Callable
from typing import Any

from nonsmooth.jit.bytecode import reading
from nonsmooth.jit.fingerprint import python_function
from nonsmooth.jit.kernels import INNER, OPTIONS
from nonsmooth.jit.libraries import is_library, library_path
from nonsmooth.jit.watch import MISSING, content_of


class Twins:
    """The copies made for one model: each function has one, however often it is called, also by itself.

    Parameters
    ----------
    key : str
        Of the model. It becomes part of their names: the linker knows functions of all models by them.
    """

    def __init__(self, key: str) -> None:
        self._key = key
        self._compiled: dict[int, Any] = {}  # by the address of what was copied
        self._modules: dict[int, types.ModuleType] = {}
        self._originals: list[Any] = []  # kept alive, so that no address is used again

    def copy(self, function: Any) -> Callable:
        """A model function that calls twins only; one that the user compiled is taken by its source."""
        source: Any = function if isinstance(function, types.FunctionType) else python_function(function)
        copy = self._shell(source)
        self._fill(copy, source)
        return copy

    def _of(self, value: Any) -> Any:
        """What takes the place of a value: the twin of a function, a tuple with twins, or the value itself."""
        if isinstance(value, tuple):
            entries = [self._of(entry) for entry in value]
            is_same = all(new is old for new, old in zip(entries, value, strict=True))
            return value if is_same else type(value)(*entries) if hasattr(value, "_fields") else tuple(entries)
        if id(value) in self._compiled:
            return self._compiled[id(value)]
        source = value if isinstance(value, types.FunctionType) else python_function(value)
        if source is None or library_path(value):
            return value
        return self._compile(value, source)

    def _compile(self, value: Any, source: types.FunctionType) -> Any:
        from nonsmooth.jit.internals import finish_twin, numba, twin_of
        from nonsmooth.jit.kernel_compiler import HelperCompiler

        copy = self._shell(source)
        ours = {**OPTIONS, **INNER, "pipeline_class": HelperCompiler}
        twin = numba.njit(**ours)(copy) if value is source else twin_of(value, copy)
        self._compiled[id(value)] = twin
        self._originals.append(value)
        self._fill(copy, source)
        finish_twin(twin, value)
        return twin

    def _fill(self, copy: Any, function: Any) -> None:
        """Give a copy its globals and closed-over variables."""
        found = reading(function.__code__)
        for name, *attributes in found.names:
            value = function.__globals__.get(name, MISSING)
            new = self._through(value, attributes)
            if new is not value:
                copy.__globals__[name] = new
        variables = function.__code__.co_freevars
        cells = dict(zip(variables, zip(function.__closure__ or (), copy.__closure__ or (), strict=True), strict=True))
        for old, new_cell in cells.values():
            if (value := content_of(old)) is not MISSING:
                new_cell.cell_contents = value
        for name, *attributes in found.free:
            old, new_cell = cells[name]
            new = self._through(content_of(old), attributes)
            if new is not content_of(old):
                new_cell.cell_contents = new

    def _through(self, value: Any, attributes: list[str]) -> Any:
        """What takes the place of a value from which these attributes are read."""
        if not isinstance(value, types.ModuleType):
            return self._of(value)
        if not attributes or is_library(value) or not hasattr(value, attributes[0]):
            return value
        old = getattr(value, attributes[0])
        new = self._through(old, attributes[1:])
        if new is old:
            return self._modules.get(id(value), value)
        if id(value) not in self._modules:
            module = self._modules[id(value)] = types.ModuleType(value.__name__)
            vars(module).update(vars(value))
            self._originals.append(value)
        setattr(self._modules[id(value)], attributes[0], new)
        return self._modules[id(value)]

    def _shell(self, function: types.FunctionType) -> types.FunctionType:
        """A copy with globals and closed-over variables of its own, which are empty yet."""
        cells = tuple(types.CellType() for _ in function.__closure__ or ())
        scope = dict(function.__globals__)
        copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__, cells or None)
        copy.__kwdefaults__ = function.__kwdefaults__
        copy.__module__, copy.__qualname__ = function.__module__, f"{function.__qualname__}.{self._key}"
        return copy
