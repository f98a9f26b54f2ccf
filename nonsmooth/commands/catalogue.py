"""Models and ready scenes by name, found through entry-point groups so that users can register their own."""

from __future__ import annotations

from importlib.metadata import EntryPoint, entry_points
from typing import Any

from nonsmooth.errors import InvalidInput, UnknownName, nearest

GROUP, SCENES = "nonsmooth.models", "nonsmooth.scenes"


def model_entries() -> dict[str, EntryPoint]:
    """The registered models by name."""
    return {entry.name: entry for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name)}


def scene_entries() -> dict[str, EntryPoint]:
    """The registered scenes by name."""
    return {entry.name: entry for entry in sorted(entry_points(group=SCENES), key=lambda entry: entry.name)}


def load_model(name: str) -> Any:
    """The class of a registered model.

    Raises
    ------
    UnknownName
        When no model of this name is registered; the message suggests the nearest.
    InvalidInput
        When another file hides the module that holds the model, and for a scene, which has no system.
    """
    entries = model_entries()
    if name in entries:
        return _load(name, entries[name], "system")
    if name in scene_entries():
        raise InvalidInput(f"{name} is a scene of bodies, which `nonsmooth run` sets in motion; a model is needed here")
    raise UnknownName(f"there is no model {name!r}; {nearest(name, entries)}")


def load_runnable(name: str) -> Any:
    """The class of a registered model or scene: what `nonsmooth run` runs; errors are those of `load_model`."""
    scenes = scene_entries()
    if name in scenes:
        return load_scene(name)
    models = model_entries()
    if name not in models:
        raise UnknownName(f"there is no model {name!r}; {nearest(name, models | scenes)}")
    return load_model(name)


def load_scene(name: str) -> Any:
    """The class of a registered scene; `InvalidInput` when another file hides its module."""
    return _load(name, scene_entries()[name], "scene")


def _load(name: str, entry: EntryPoint, method: str) -> Any:
    try:
        model = entry.load()
    except (ImportError, AttributeError) as error:
        raise InvalidInput(
            f"the model {name} could not be loaded from {entry.value}: {error}; {_hider(entry)}"
        ) from error
    if not callable(getattr(model, method, None)):
        raise InvalidInput(f"{entry.value} is no {_word(method)}: it has no {method}() method; {_hider(entry)}")
    return model


def _word(method: str) -> str:
    return "model" if method == "system" else "scene"


def _hider(entry: EntryPoint) -> str:
    """Which file answers to the package's name: a user's own models.py may hide ours."""
    import importlib.util

    package = entry.module.split(".")[0]
    spec = importlib.util.find_spec(package)
    where = spec.origin if spec else "nowhere"
    return f"the name {package!r} is found at {where}; rename that file if it is yours"
