"""What machine code depends on apart from its source: versions, processor, numba's options, found without numba.

Its import takes 0.28 s, and a process that finds all its code on the disk needs nothing else of it (`linking`). Its
version is read from a file of its own. Its options are made by its own module of options, run alone, which reads the
environment and `.numba_config` in the working folder; once numba is imported, they are what it has.
"""

from __future__ import annotations

import builtins
import contextlib
import ctypes
import functools
import importlib.util
import re
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.errors import UnsupportedVersion

# measured: versions of numba: the first that was tested, and the first that was not
LOWEST, UNTESTED = (0, 61, 2), (0, 69)
CHOSEN = ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "ENABLE_AVX", "CPU_NAME", "CPU_FEATURES",
          "DISABLE_INTEL_SVML", "DEBUGINFO_DEFAULT")  # fmt: skip
FILES_OF_OPTIONS = ".numba_config.*"  # defined: by numba, in the working folder
OF_NUMBA = {"numba", "llvmlite"}  # defined: the packages that are part of it
SVML = {"linux": "libsvml.so", "darwin": "libsvml.dylib", "win32": "svml_dispmd"}  # defined: where numba looks for it


def surroundings() -> tuple[str, ...]:
    """Each as a text."""
    options = options_of_numba()
    python = f"{sys.implementation.name} {sys.version_info[:3]} {sys.maxsize.bit_length() + 1} bits"
    return python, *fixed(), *(f"{name}={getattr(options, name, None)}" for name in CHOSEN)


@functools.cache
def fixed() -> tuple[str, ...]:
    """What stays as it is within a process."""
    import llvmlite
    import llvmlite.binding as llvm

    versions = f"numpy {np.__version__}", f"numba {version_of_numba()}", f"llvmlite {llvmlite.__version__}"
    processor = llvm.get_process_triple(), llvm.get_host_cpu_name(), features_of_processor()
    return *versions, *processor, f"SVML={has_svml()}"


def features_of_processor() -> str:
    """Its instructions; nothing where LLVM knows none, as to numba."""
    import llvmlite.binding as llvm

    try:
        return str(llvm.get_host_cpu_features().flatten())
    except RuntimeError:
        return ""


def imported_numba() -> types.ModuleType:
    """Numba.

    Raises
    ------
    UnsupportedVersion
        Where it cannot be imported.
    """
    try:
        return importlib.import_module("numba")
    except ImportError as error:
        raise UnsupportedVersion(f"numba cannot be imported: {error}") from error


def require_tested(version: str) -> None:
    """Refuse a numba that was not tested.

    Raises
    ------
    UnsupportedVersion
    """
    if not LOWEST <= tuple(map(int, re.findall(r"\d+", version)[:3])) < UNTESTED:
        lowest, untested = (".".join(map(str, bound)) for bound in (LOWEST, UNTESTED))
        raise UnsupportedVersion(
            f'numba {version} was not tested with nonsmooth: pip install "numba>={lowest},<{untested}"'
        )


def version_of_numba() -> str:
    """The version that is imported, or installed: from the file that was written as it was built."""
    if "numba" in sys.modules:
        return str(imported_numba().__version__)
    file = folder_of_numba() / "_version.py"
    found = re.search(r'"version": "(.+)"', file.read_text()) if file.is_file() else None
    return found[1] if found else str(imported_numba().__version__)


def folder_of_numba() -> Path:
    """Where numba is installed.

    Raises
    ------
    UnsupportedVersion
        Where there is none, or it cannot be imported.
    """
    spec = importlib.util.find_spec("numba")
    if spec is None or spec.origin is None:
        return Path(str(imported_numba().__file__)).parent
    return Path(spec.origin).parent


def options_of_numba() -> types.ModuleType:
    """Numba's options: what it has, or would have if it were imported."""
    return sys.modules.get("numba.core.config") or _options_by_themselves()


@functools.cache
def _options_by_themselves() -> types.ModuleType:
    if not any(Path().glob(FILES_OF_OPTIONS)):
        with contextlib.suppress(ImportError):
            return _module_of_options(__builtins__={**vars(builtins), "__import__": _import_own})
    return _module_of_options()


def _module_of_options(**names: Any) -> types.ModuleType:
    """The module, run with some names in it."""
    spec: Any = importlib.util.spec_from_file_location("options", folder_of_numba() / "core" / "config.py")
    options = importlib.util.module_from_spec(spec)
    vars(options).update(names)
    spec.loader.exec_module(options)
    return options


def _import_own(name: str, *given: Any) -> Any:
    """Without what reads the file of options, where there is none: that takes 10 ms, and the module does without."""
    if name.partition(".")[0] not in sys.stdlib_module_names | OF_NUMBA:
        raise ImportError(f"{name} has nothing to read")
    return builtins.__import__(name, *given)


def has_svml() -> bool:
    """Whether the vector functions of Intel's library are there, which numba takes where they are."""
    try:
        ctypes.CDLL(SVML[sys.platform])
    except (OSError, KeyError):
        return False
    return True
