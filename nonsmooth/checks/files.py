"""Files: written whole, beside their place and moved there once complete; read with one way to refuse them.

A reader sees the old file or the new one, never a part of one; a kill or a full disk leaves the old one there.
"""

from __future__ import annotations

import contextlib
import os
import stat
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

from nonsmooth.errors import FileFailure, InvalidInput, NonsmoothError, shown

FIGURE_ENDINGS = (".png", ".pdf", ".svg", ".eps", ".jpg", ".webp")
ANIMATION_ENDINGS = (".gif", ".webp", ".mp4")
PAGE_ENDINGS = (".html", ".htm")


def as_path(name: str, value: Any) -> Path:
    """The path of a file, or `InvalidInput`."""
    try:
        text = os.fspath(value)
        if not isinstance(text, str) or "\0" in text or not text:
            raise TypeError
        path = Path(text)
        path.exists()
    except OSError as error:  # a name that is too long
        raise InvalidInput(
            f"{name} cannot be written or read: {error.strerror}; choose another path than {shown(value)}"
        ) from None
    except Exception:  # whatever an object raises that is asked for its path
        raise InvalidInput(f"{name} must be the path of a file; got {shown(value)}") from None
    return path


def as_place(name: str, path: Any, endings: Sequence[str]) -> Path:
    """The path of a file that can be written there, or `InvalidInput`.

    Parameters
    ----------
    name : str
        Of the argument, for the message.
    path : path-like
    endings : sequence of str
        Those that name a format.
    """
    path = as_path(name, path)
    try:
        if path.suffix not in endings:
            what = "is a folder; the file in it" if path.is_dir() else "is no file name here: it"
            raise InvalidInput(f"{str(path)!r} {what} must end in one of {', '.join(endings)}")
        part = part_of(path)
        if not path.parent.is_dir():
            raise FileNotFoundError(f"there is no folder {str(path.parent)!r}")
        if path.is_dir():
            raise IsADirectoryError("it is a folder")
        is_left_over = part.exists()
        if path.exists() and not os.access(path, os.W_OK):
            raise PermissionError("the file there may not be changed")
        part.open("ab").close()
        if not is_left_over:
            part.unlink()
    except OSError as error:
        where = shown(str(path))
        raise InvalidInput(f"{where} cannot be written: {error.strerror or error}; choose another path") from None
    return path


def open_to_read(path: Path) -> BinaryIO:
    """Open an ordinary file; a folder, a pipe or a device, at which a reader would wait for ever, is refused."""
    if not stat.S_ISREG(os.stat(path).st_mode):
        raise ValueError("it is no ordinary file")
    return path.open("rb")


@contextlib.contextmanager
def refusals(path: Path, what: str) -> Iterator[None]:
    """Say in one `InvalidInput` whatever readers of .npz, .h5, .nc and JSON raise on a file that they cannot read.

    Parameters
    ----------
    path : Path
    what : str
        What the file is not, to which ", or is damaged" is added: "is no result of a sweep".
    """
    try:
        yield
    except NonsmoothError:
        raise
    except FileNotFoundError:
        raise InvalidInput(f"there is no file {str(path)!r}") from None
    except Exception as error:  # a damaged file may make its reader raise anything
        said = " ".join(str(error).split()) or type(error).__name__
        raise InvalidInput(f"{path.name} {what}, or is damaged: {said}") from error


def part_of(path: Path) -> Path:
    """Where a file stands until it is whole."""
    return path.with_name(path.name + ".part")


@contextlib.contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """The path to write to; what was written is moved to ``path`` at the end, and removed after a failure.

    Raises
    ------
    FileFailure
        Where the system refuses to write, as it does when the disk is full.
    """
    part = part_of(path)
    try:
        yield part
        with part.open("rb") as file:
            os.fsync(file.fileno())
        os.replace(part, path)
    except OSError as error:
        raise FileFailure(
            f"{str(path)!r} could not be written: {error.strerror or error}; what was there before is unchanged: make "
            "room, or choose another path"
        ) from error
    finally:
        part.unlink(missing_ok=True)
