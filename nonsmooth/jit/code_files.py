"""Files of machine code: one a compiled function, with a checksum and with what it is.

    line      "nonsmooth machine code 1"
    32 bytes  SHA-256 of all that follows
    8 bytes   length of the description, 8 bytes length of the code
    text      description: name, key, versions, processor
    bytes     the code, as numba pickles it

A pickle runs what stands in it, so nothing is unpickled before the file and its folder are found to be the user's own
or the system's, not writable by others, the checksum is right, and the description is that of what is wanted. A file is
written to a temporary name and moved into place: a reader sees a whole file or none.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

MAGIC = b"nonsmooth machine code 1\n"
HASH = 32  # defined: bytes of SHA-256
LENGTH_BYTES = 8  # defined: bytes of a length
ENDING, PART = ".code", ".part"
DAY = 86400.0  # defined: s
LONGEST_UNUSED = 60 * DAY  # chosen: then a file is removed: a study that is taken up again compiles once more
# measured: bytes; beyond it what was unused longest goes. A model takes 60 kB, all our loops 5 MB
LARGEST_CACHE = 256 * 2**20
# defined: a link is refused, a pipe is not waited for; Windows, which has neither flag, would change ends of lines.
READ_ONLY = os.O_RDONLY | sum(getattr(os, flag, 0) for flag in ("O_NOFOLLOW", "O_NONBLOCK", "O_BINARY"))


class Unfit(Exception):
    """A file is not what was written there; ``str`` says why."""


class CodeFile:
    """The file of one compiled function, or none where there is no folder for it.

    Parameters
    ----------
    folder : Path or None
    name : str
        Of the function.
    key : str
        Hash of all that the code is made from.
    description : str
    """

    def __init__(self, folder: Path | None, name: str, key: str, description: str) -> None:
        self._folder = folder
        self._source_stamp = key  # as numba names it
        self._description = f"{name}\n{key}\n{description}".encode()
        self.path = None if folder is None else folder / f"{name}-{key[:32]}{ENDING}"

    @property
    def exists(self) -> bool:
        """Whether something is kept there."""
        return self.path is not None and os.path.isfile(self.path)

    def load(self, rebuild: Callable[[bytes], Any]) -> Any:
        """What ``rebuild`` makes of the code; None where there is none, or none that fits."""
        if self.path is None or not os.path.lexists(self.path):
            return None
        try:
            code = _read(self.path, self._description)
            return rebuild(code)
        except FileNotFoundError:  # removed by another process
            return None
        except Unfit as reason:
            note("unfit", f"{self.path} is {reason}; it is compiled again")
        except Exception as error:  # unpickling may raise anything
            note("unfit", f"{self.path} does not fit ({type(error).__name__}); it is compiled again")
        return None

    def save(self, code: bytes) -> None:
        """Write the code, and remove old files if there are too many."""
        if self.path is None or self._folder is None:
            return
        lengths = b"".join(len(part).to_bytes(LENGTH_BYTES, "little") for part in (self._description, code))
        content = lengths + self._description + code
        try:
            _write(self.path, MAGIC + hashlib.sha256(content).digest() + content)
            remove_old(self._folder)
        except OSError as error:
            note("unwritten", f"{self._folder} keeps no compiled code: {error.strerror or error}")


def _read(path: Path, description: bytes) -> bytes:
    """The code of a file that is found to be whole, our own, and what it is asked for."""
    handle = _open(path)
    facts = os.fstat(handle)
    with open(handle, "rb") as file:
        head = file.read(len(MAGIC) + HASH + 2 * LENGTH_BYTES)
        lengths = [int.from_bytes(head[-2 * LENGTH_BYTES :][i : i + LENGTH_BYTES], "little") for i in (0, LENGTH_BYTES)]
        if not head.startswith(MAGIC) or len(head) + sum(lengths) != facts.st_size:
            raise Unfit("damaged")
        content = head[-2 * LENGTH_BYTES :] + file.read()
    if hashlib.sha256(content).digest() != head[len(MAGIC) : len(MAGIC) + HASH]:
        raise Unfit("damaged")
    if content[2 * LENGTH_BYTES :][: lengths[0]] != description:
        raise Unfit("of another function, or of another version")
    if time.time() - facts.st_mtime > DAY:
        with contextlib.suppress(OSError):  # so that it is known to be in use
            os.utime(path)
    return content[2 * LENGTH_BYTES + lengths[0] :]


def _open(path: Path) -> int:
    """Open a file, and nothing else that may stand there."""
    try:
        handle = os.open(path, READ_ONLY)
    except FileNotFoundError:
        raise
    except OSError as error:
        raise Unfit(f"not readable ({error.strerror})") from None
    facts = os.fstat(handle)
    if stat.S_ISREG(facts.st_mode) and not others_may_write(facts):
        return handle
    os.close(handle)
    raise Unfit("passed over, as others may write it" if stat.S_ISREG(facts.st_mode) else "no file")


def _write(path: Path, content: bytes) -> None:
    """Write to a temporary name, and move into place."""
    handle, part = tempfile.mkstemp(suffix=PART, prefix=path.stem, dir=path.parent)
    try:
        with open(handle, "wb") as file:
            file.write(content)
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        os.replace(part, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(part)
        raise


def others_may_write(facts: os.stat_result) -> bool:
    """Whether a file or folder belongs to another user than oneself and the system's, or can be written by others."""
    if not hasattr(os, "getuid"):  # Windows keeps such rights elsewhere
        return False
    return facts.st_uid not in (0, os.getuid()) or bool(facts.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


def usable(folder: Path) -> bool:
    """Make the folder; False, with a note, where it cannot be made or others may write in it."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        is_open = others_may_write(folder.stat())
    except OSError as error:
        note("unusable", f"{folder} keeps no compiled code: {error.strerror or error}")
        return False
    if is_open:
        note("unusable", f"{folder} is passed over, as others may write there: chmod go-w, or set NONSMOOTH_CACHE_DIR")
    return not is_open


def remove_old(folder: Path) -> None:
    """Remove what was unused for long, what is too much, and what a killed process left.

    Whoever still needs a file compiles it again: none is needed after it was read.
    """
    now = time.time()
    kept: list[tuple[float, int, str]] = []
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.endswith((ENDING, PART)) and entry.is_file(follow_symlinks=False):
                try:
                    facts = entry.stat(follow_symlinks=False)
                except OSError:  # another process was faster
                    continue
                age = now - facts.st_mtime
                if age > (LONGEST_UNUSED if entry.name.endswith(ENDING) else DAY):
                    _remove(entry.path)
                elif entry.name.endswith(ENDING):
                    kept.append((age, facts.st_size, entry.path))
    size = sum(length for _, length, _ in kept)
    for _, length, path in sorted(kept, reverse=True):
        if size <= LARGEST_CACHE:
            break
        _remove(path)
        size -= length


def _remove(path: str) -> None:
    with contextlib.suppress(OSError):  # another process was faster
        os.unlink(path)


def note(kind: str, text: str) -> None:
    """Say something on stderr, once a process and kind."""
    if kind not in _noted:
        _noted.add(kind)
        print(f"nonsmooth: {text}", file=sys.stderr)


_noted: set[str] = set()
