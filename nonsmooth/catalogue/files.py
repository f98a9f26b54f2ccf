"""Models of a file: of ``my.py:Rod`` a class, an instance, a `System`, a `Scene`, or a function that returns one; of
``tower.toml``, or an MJCF or URDF file, a scene (scenes/scene_files.py)."""

from __future__ import annotations

import importlib.util
import inspect
import itertools
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

from nonsmooth.errors import InvalidInput, UnknownName, nearest, said_by

ENDING = ".py"
OF_SCENES = (".toml", ".xml", ".mjcf", ".urdf")


def is_file(text: str) -> bool:
    """Whether a text means a file, or something in one."""
    return split(text)[0].endswith((ENDING, *OF_SCENES))


def split(text: str) -> tuple[str, str]:
    """The file and the name in it: ("my.py", "Rod"); the name may be missing."""
    path, sign, name = text.rpartition(":")
    return (path, name) if sign and path.endswith(ENDING) else (text, "")


def load_file(path: str) -> ModuleType:
    """The module of a file, run once a process; its folder is searched for what it imports.

    Raises
    ------
    InvalidInput
        When there is no such file, or when it raises.
    """
    place = Path(path).resolve()
    if not place.is_file():
        raise InvalidInput(f"there is no file {path}")
    if place.suffix != ".py":
        raise InvalidInput(f"{path} is no Python file; its name must end with .py")
    name = _name_of(place)
    if name in sys.modules:
        return sys.modules[name]
    if str(place.parent) not in sys.path:
        sys.path.insert(0, str(place.parent))
    spec = importlib.util.spec_from_file_location(name, place)
    assert spec is not None and spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever the file raises, sys.exit() included
        del sys.modules[name]
        raise InvalidInput(f"{path} cannot be run: {said_by(error)}{_line_of(error, place)}") from error
    return module


def _name_of(place: Path) -> str:
    """The name under which other processes find the module too; another one where that is taken."""
    names = itertools.chain([place.stem], (f"file{k or ''}_{place.stem}" for k in itertools.count()))
    return next(name for name in names if name not in sys.stdlib_module_names and _is_free(name, place))


def _is_free(name: str, place: Path) -> bool:
    """Whether no module has the name, or that of this file."""
    known = sys.modules.get(name)
    return known is None or str(getattr(known, "__file__", "")) == str(place)


def _line_of(error: BaseException, place: Path) -> str:
    """The last line of the file that the error came through."""
    line, trace = 0, error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == str(place):
            line = trace.tb_lineno
        trace = trace.tb_next
    if isinstance(error, SyntaxError) and error.lineno:
        line = error.lineno
    return f" (line {line})" if line else ""


def found_in(module: ModuleType) -> dict[str, Any]:
    """What can be run of a module, by name: classes of models and their instances, systems and scenes."""
    return {name: value for name, value in vars(module).items() if _is_own(module, value) and is_runnable(value)}


def _is_own(module: ModuleType, value: Any) -> bool:
    return not isinstance(value, type) or value.__module__ == module.__name__


def is_runnable(value: Any) -> bool:
    """Whether a value is a system, a scene, a model, or a class of models."""
    from nonsmooth.mechanics.system import System
    from nonsmooth.scenes.scene import Scene

    if isinstance(value, System | Scene):
        return True
    return any(callable(getattr(value, method, None)) for method in ("system", "scene")) and value not in (Scene,)


def as_typed(name: str, text: str, default: Any) -> Any:
    """An argument as the text that was typed."""
    return text


def from_file(
    text: str, arguments: dict[str, str] | None = None, read: Callable[[str, str, Any], Any] = as_typed
) -> tuple[str, Any]:
    """The name and the value of what ``FILE:NAME`` means; of a file with one model its name may be left out.

    A function takes those of the ``arguments`` that it has, texts that ``read(name, text, default)`` makes values; they
    are taken out of them.

    Raises
    ------
    UnknownName
        For a name that the file does not have.
    InvalidInput
        For a file without models, one with several where no name was given, and for what is no model.
    """
    if text.endswith(OF_SCENES):
        return Path(text).stem, scene_of_file(text, {} if arguments is None else arguments, read)
    path, name = split(text)
    module = load_file(path)
    found = found_in(module)
    if not name:
        if len(found) != 1:
            said = f"has {', '.join(found)}: say which, as {path}:{next(iter(found))}" if found else "has no model"
            raise InvalidInput(f"{path} {said}")
        name = next(iter(found))
    if not hasattr(module, name):
        raise UnknownName(f"{path} has no {name}; {nearest(name, found)}")
    value = getattr(module, name)
    if not is_runnable(value) and callable(value):
        value = _returned(text, value, {} if arguments is None else arguments, read)
    if not is_runnable(value):
        others = f"; {path} has the models {', '.join(found)}" if found else ""
        raise InvalidInput(
            f"{text} is no model: a System, a Scene, a class or an instance with system() or scene(), or a function "
            f"that returns one{others}"
        )
    return name, value


def scene_of_file(path: str, arguments: dict[str, str], read: Callable[[str, str, Any], Any]) -> Any:
    """The scene of a file, with those of the arguments that are values of it; they are taken out of them."""
    from nonsmooth.scenes.scene_files import load_scene, values_in

    own = values_in(path)
    return load_scene(path, **{name: read(name, arguments.pop(name), own[name]) for name in own if name in arguments})


def _returned(text: str, function: Any, arguments: dict[str, str], read: Callable[[str, str, Any], Any]) -> Any:
    try:
        taken = inspect.signature(function).parameters.items()
    except (TypeError, ValueError) as error:  # of a function that does not say what it takes
        raise InvalidInput(f"{text} cannot be called: {said_by(error)}") from error
    values = {name: read(name, arguments.pop(name), one.default) for name, one in taken if name in arguments}
    try:
        return function(**values)
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # whatever the function raises
        raise InvalidInput(f"{text} cannot be called: {said_by(error)}") from error
