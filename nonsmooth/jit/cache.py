"""The disk cache of compiled code: what was compiled once is read by every later process."""

from __future__ import annotations

import functools
import hashlib
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

PACKAGE = Path(__file__).parent
GENERATORS = (*sorted(PACKAGE.glob("*.py")), PACKAGE.parent / "blocks.py")  # sources that generate code themselves


def cache_directory() -> Path:
    """Where compiled code is kept: ``$NONSMOOTH_CACHE_DIR``, else ``nonsmooth`` under the user's cache directory."""
    if "NONSMOOTH_CACHE_DIR" in os.environ:
        return Path(os.environ["NONSMOOTH_CACHE_DIR"])
    if sys.platform == "win32":
        root = Path(os.environ.get("LOCALAPPDATA", "~"))
    else:
        root = Path(os.environ.get("XDG_CACHE_HOME", "~/.cache"))
    return (root / "nonsmooth").expanduser()


def directory_of(stamp: str) -> Path:
    """Where the code under a stamp is kept."""
    return cache_directory() / stamp[:16]


def is_cached(stamp: str) -> bool:
    """Whether code is on disk under this stamp."""
    return any(directory_of(stamp).glob("*.nbi"))


@functools.cache
def runtime_stamp() -> str:
    """Hash of the sources that generate code themselves: they shape every compiled function."""
    return hashlib.sha256(b"".join(path.read_bytes() for path in GENERATORS)).hexdigest()


def compile_cached(function: Callable, signature: Any, stamp: str, **options: Any) -> Any:
    """Compile for one signature, reading or filling the disk cache under the given stamp."""
    import numba

    dispatcher = numba.njit(**options)(function)
    if not numba.config.DISABLE_JIT:
        dispatcher._cache = _stamped_cache(function, stamp)
        dispatcher.compile(signature)
        dispatcher.disable_compile()
    return dispatcher


def _stamped_cache(function: Callable, stamp: str) -> Any:
    """A numba function cache whose freshness is our stamp, not the file's date, so that generated code is kept too."""
    from numba.core import caching

    directory = directory_of(stamp)

    class Locator(caching._CacheLocator):
        """Where one function is kept, and what makes it stale."""

        def get_cache_path(self) -> str:
            """The folder."""
            return str(directory)

        def get_source_stamp(self) -> str:
            """What must be equal for the kept code to be taken."""
            return stamp

        def get_disambiguator(self) -> str:
            """The part of the file's name that tells functions of one name apart."""
            return stamp[16:24]

        @classmethod
        def from_function(cls, py_func: Callable, py_file: str) -> Locator:
            """The locator of any function."""
            return cls()

    class Implementation(caching.CompileResultCacheImpl):
        """Numba's own form of results, in our place."""

        _locator_classes = [Locator]

    class Cache(caching.FunctionCache):
        """Numba's own cache, with our locator."""

        _impl_class = Implementation

    try:
        directory.mkdir(parents=True, exist_ok=True)
    except OSError:
        return caching.NullCache()  # nowhere to write: compile in every process
    return Cache(function)
