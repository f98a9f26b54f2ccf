"""What a model that was derived from energies has beside its own functions: its source, and closed forms."""

from __future__ import annotations

import inspect
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.errors import FileFailure, InvalidInput

if TYPE_CHECKING:
    from nonsmooth.symbolic.critical import CriticalFriction

SEAL = "# sha256 of the lines above: "  # the last line of a file that is kept, not of one that is saved


class DerivedModel:
    """Base of the dataclasses that are written from energies, and of those that a user keeps and edits."""

    def source(self) -> str:
        """The source of this model: the functions, and the dataclass of its parameters."""
        source, seal, after = inspect.getsource(sys.modules[type(self).__module__]).rpartition(SEAL)
        return source if seal else after

    def save(self, path: str | Path) -> Path:
        """Write the source as a Python file, to be kept, edited and imported.

        Raises
        ------
        InvalidInput
            Where the path does not end in .py, as an import needs it.
        FileFailure
            Where it cannot be written.
        """
        try:
            file = Path(path)
        except TypeError:
            raise InvalidInput(f"path must be the name of a file; got {type(path).__name__}") from None
        if file.suffix != ".py" or not file.stem.isidentifier():
            raise InvalidInput(f"path must end in .py and have a name that can be imported; got {file.name!r}")
        try:
            file.write_text(self.source(), encoding="utf-8")
        except OSError as error:
            raise FileFailure(f"{file} cannot be written: {error.strerror or error}") from error
        return file

    def critical_friction(self, contact: int | str = 0) -> CriticalFriction:
        """The friction above which a contact has a paradox, as an expression; see `critical.critical_friction`."""
        from nonsmooth.symbolic.critical import critical_friction

        return critical_friction(self, contact)
