"""What is given in the place of a scene; where it is none, neither NumPy nor the room of scenes is loaded."""

from __future__ import annotations

import sys
from dataclasses import is_dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nonsmooth.scenes.scene import Scene


def as_scene(candidate: Any) -> Scene | None:
    """The scene itself, or the one that a ready scene builds with its ``scene()`` method; None for what has none."""
    if is_scene_object(candidate):
        return candidate  # type: ignore[no-any-return]
    if isinstance(candidate, type) or not callable(getattr(candidate, "scene", None)):
        return None
    from nonsmooth.checks.arrays import as_instance
    from nonsmooth.checks.parameters import numeric_fields
    from nonsmooth.mechanics.start import own_time
    from nonsmooth.scenes.scene import Scene

    name = type(candidate).__name__
    scene: Scene = as_instance(f"what scene() of {name} returns", candidate.scene(), Scene, "an ns.Scene")
    scene.name = scene.name or str(getattr(candidate, "name", name))
    scene.t_end, scene.dt = (own_time(candidate, time) or getattr(scene, time) for time in ("t_end", "dt"))
    has_fields = is_dataclass(candidate) or hasattr(candidate, "_fields")
    scene.built_from = numeric_fields(candidate) if has_fields else None
    return scene


def as_model(candidate: Any) -> Any:
    """The system of a scene, also of one that a ready scene builds; whatever else is a model itself."""
    has_system = callable(getattr(candidate, "system", None)) and not is_scene_object(candidate)
    scene = None if has_system else as_scene(candidate)
    return candidate if scene is None else scene.system()


def is_scene_object(candidate: Any) -> bool:
    """Whether it is a scene: who has made one has loaded its class."""
    loaded = sys.modules.get("nonsmooth.scenes.scene")
    return loaded is not None and isinstance(candidate, loaded.Scene)
