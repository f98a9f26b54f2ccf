"""Functions and classes that are known by their name: those of packages whose version belongs to every key."""

from __future__ import annotations

import functools
import os
import sys
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

VERSIONED = {"numpy", "numba", "llvmlite"}
STANDARD_LIBRARY = Path(os.__file__).parent


def is_library(module: types.ModuleType) -> bool:
    """Whether a module belongs to Python itself, or to a package whose version is in the key."""
    top = module.__name__.partition(".")[0]
    return top in VERSIONED or (top in sys.stdlib_module_names and _is_in_standard_library(module.__name__))


@functools.cache
def _is_in_standard_library(name: str) -> bool:
    """Whether a module of this name comes with Python, and is not the user's of the same name."""
    module = sys.modules.get(name)
    origin = getattr(getattr(module, "__spec__", None), "origin", None)
    if origin in ("built-in", "frozen"):
        return True
    path = Path(origin or "")
    inner = path.parts[len(STANDARD_LIBRARY.parts) :]
    return bool(inner) and path.is_relative_to(STANDARD_LIBRARY) and not inner[0].endswith("-packages")


def name_of(value: Any) -> str:
    """What a function or class calls itself, "" for what has no name."""
    # a method of numpy's one generator is known by its own name alone: np.random.rand
    path = None if isinstance(value, types.MethodType) else getattr(value, "__qualname__", None)
    name = path or getattr(value, "__name__", None)
    return name if isinstance(name, str) else ""


def library_path(value: Any, is_library: Callable[[types.ModuleType], bool] = is_library) -> str:
    """``module.name`` of a function or class that a library has under this name; "" for others."""
    name = name_of(value)
    homes = [getattr(value, "__module__", None)] if name else []
    if isinstance(value, np.ufunc | types.BuiltinFunctionType | types.MethodType):
        homes += ["numpy", "numpy.random"]  # ufuncs, and the functions of numpy's one generator, name no module
    for home in homes:
        module = sys.modules.get(home) if isinstance(home, str) else None
        if module is not None and is_library(module) and _at(module, name) is value:
            return f"{home}.{name}"
    return ""


def _at(module: types.ModuleType, name: str) -> Any:
    value: Any = module
    for part in name.split("."):
        value = getattr(value, part, None)
    return value


def is_installed(module: types.ModuleType) -> bool:
    """Whether a module lies among installed packages."""
    return any(part.endswith("-packages") for part in Path(getattr(module, "__file__", None) or "").parts)
