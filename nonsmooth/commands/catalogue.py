"""Models by name, found through the entry-point group ``nonsmooth.models`` so that users can register their own."""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points
from typing import Any

from nonsmooth.errors import InvalidInput, UnknownName, nearest

GROUP = "nonsmooth.models"


def model_entries() -> dict[str, EntryPoint]:
    """The registered models by name."""
    return {entry.name: entry for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name)}


def load_model(name: str) -> Any:
    """The class of a registered model.

    Raises
    ------
    UnknownName
        When no model of this name is registered; the message suggests the nearest.
    InvalidInput
        When another file hides the module that holds the model.
    """
    entries = model_entries()
    if name not in entries:
        raise UnknownName(f"there is no model {name!r}; {nearest(name, entries)}")
    entry = entries[name]
    try:
        model = entry.load()
    except (ImportError, AttributeError) as error:
        raise InvalidInput(
            f"the model {name} could not be loaded from {entry.value}: {error}; {_hider(entry)}"
        ) from error
    if not callable(getattr(model, "system", None)):
        raise InvalidInput(f"{entry.value} is no model: it has no system() method; {_hider(entry)}")
    return model


def _hider(entry: EntryPoint) -> str:
    """Which file answers to the package's name: a user's own models.py may hide ours."""
    import importlib.util

    package = entry.module.split(".")[0]
    spec = importlib.util.find_spec(package)
    where = spec.origin if spec else "nowhere"
    return f"the name {package!r} is found at {where}; rename that file if it is yours"
