"""Modules that were written from energies, kept beside the compiled code: one a declaration, imported by its name.

The name of a file has a hash of all that the source is made from; its last line has one of the source above it, so
that a file that is damaged, cut or edited is written anew. The folder must belong to the user and be closed to others,
since what stands there is run.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import importlib
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

from nonsmooth.jit.cache import cache_directory
from nonsmooth.jit.code_files import LONGEST_UNUSED, others_may_write, usable
from nonsmooth.symbolic.derived_model import SEAL


def _folder() -> Path:
    """Where the files are; of this process alone where nothing can be kept."""
    kept = cache_directory() / "models"
    if not usable(kept):
        kept = Path(_folder_of_this_process())
    if str(kept) not in __path__:
        __path__.insert(0, str(kept))
        importlib.invalidate_caches()
    return kept


def _folder_of_this_process() -> str:
    if not _temporary:
        _temporary.append(tempfile.TemporaryDirectory(prefix="nonsmooth-models-"))
        atexit.register(_temporary[0].cleanup)
    return _temporary[0].name


_temporary: list[tempfile.TemporaryDirectory] = []


def module_of(name: str, write: Callable[[], str]) -> ModuleType:
    """The module of a source that is kept under a name, or is written now."""
    file = _folder() / f"{name}.py"
    known = sys.modules.get(f"{__name__}.{name}")
    if not _is_whole(file):
        _save(file, write())
    elif known is not None:
        return known
    importlib.invalidate_caches()
    sys.modules.pop(f"{__name__}.{name}", None)
    return importlib.import_module(f"{__name__}.{name}")


def _is_whole(file: Path) -> bool:
    try:
        text = file.read_text(encoding="utf-8")
        facts = file.stat()
    except (OSError, UnicodeDecodeError):
        return False
    source, found, seal = text.rpartition(SEAL)
    is_whole = bool(found) and seal.strip() == _hash(source) and not others_may_write(facts)
    if is_whole:
        with contextlib.suppress(OSError):  # so that it is known to be in use
            os.utime(file, (time.time(), facts.st_mtime))
    return is_whole


def _save(file: Path, source: str) -> None:
    """Write beside the place and move there: a reader sees a whole file or none."""
    handle, part = tempfile.mkstemp(suffix=".part", prefix=file.stem, dir=file.parent)
    try:
        with open(handle, "w", encoding="utf-8") as open_file:
            open_file.write(f"{source}{SEAL}{_hash(source)}\n")
        os.replace(part, file)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(part)
        raise
    _remove_unused(file.parent)


def _remove_unused(folder: Path) -> None:
    """Remove what no process read for long."""
    for file in folder.glob("*.py"):
        with contextlib.suppress(OSError):
            if time.time() - file.stat().st_atime > LONGEST_UNUSED:
                file.unlink()


def _hash(source: str) -> str:
    return hashlib.sha256(source.encode()).hexdigest()


with contextlib.suppress(Exception):  # so that another process finds what this one wrote
    _folder()
